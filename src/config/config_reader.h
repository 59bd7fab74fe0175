// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "config_table.h"
#include "mscomp/base/error.h"

namespace mscomp {

/// The one document that `yaml` holds, null if it is empty. Throws ConfigError with place and `key`
/// for broken YAML or a second document.
YAML::Node load_document(std::string yaml, const std::string& path, const std::string& key);

/// The model kind that a document with `overrides` asks for; the first kind where it names none or
/// one that is not known, which reading then says. Throws ConfigError for broken YAML.
std::string kind_in(const YAML::Node& document, const std::vector<std::string>& overrides);

/// A dotted key and its value, as they stand in a file.
struct Setting {
    std::string key;
    FilePosition where;  // of the key
    YAML::Node value;
};
/// The model kind that a setting names, if it is a known one.
std::optional<std::string> kind_in(const Setting& setting);

/// Fills a configuration from YAML, key by key of the table, and remembers where each one stood.
class ConfigReader {
  public:
    explicit ConfigReader(Config& config) : config_(config), table_(config_table(config)) {}

    /// A whole document. Throws ConfigError.
    void read_document(const YAML::Node& root, const std::string& path);
    /// One "dotted.key=value". Throws ConfigError.
    void read_override(const std::string& text);
    /// One dotted key of another file. Throws ConfigError.
    void read_setting(const Setting& setting);
    /// What only the whole can tell: required keys that are missing. Throws ConfigError.
    void check(const std::string& path) const;

  private:
    void read_field(const Key& key, const YAML::Node& node, const std::string& dotted);
    void read_table(const Table& table, const YAML::Node& node, const std::string& dotted,
                    bool is_new_entry);
    void read_list(const List& list, const YAML::Node& node, const std::string& dotted);
    Key find(std::string_view dotted, const FilePosition& where) const;
    [[noreturn]] void fail_unknown(FilePosition where, const std::string& dotted) const;
    FilePosition where(std::string dotted, const std::string& path) const;

    Config& config_;
    Table table_;
    std::string path_;                          // of what is being read
    std::map<std::string, FilePosition> seen_;  // dotted key -> where its value stood last
};

}  // namespace mscomp
