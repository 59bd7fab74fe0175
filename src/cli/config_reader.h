// SPDX-License-Identifier: MIT
#pragma once

#include <yaml-cpp/yaml.h>

#include <map>
#include <string>
#include <string_view>
#include <vector>

#include "config_table.h"
#include "mscomp/base/error.h"

namespace mscomp {

/// The model kind that a document with `overrides` asks for; the first kind where it names none or
/// one that is not known, which reading then says. Throws ConfigError for broken YAML.
std::string kind_in(std::string_view yaml, const std::string& path,
                    const std::vector<std::string>& overrides);

/// Fills a configuration from YAML, key by key of the table, and remembers where each one stood.
class ConfigReader {
  public:
    explicit ConfigReader(nn::Config& config) : config_(config), table_(config_table(config)) {}

    /// A whole document. Throws ConfigError.
    void read_document(std::string_view yaml, const std::string& path);
    /// One "dotted.key=value". Throws ConfigError.
    void read_override(const std::string& text);
    /// What only the whole can tell: required keys that are missing. Throws ConfigError.
    void check(const std::string& path) const;

  private:
    void read_field(const Key& key, const YAML::Node& node, const std::string& dotted);
    void read_table(const Table& table, const YAML::Node& node, const std::string& dotted,
                    bool is_new_entry);
    void read_levels(std::vector<nn::LevelConfig>& levels, const YAML::Node& node,
                     const std::string& dotted);
    Key find(std::string_view dotted) const;
    [[noreturn]] void fail_unknown(FilePosition where, const std::string& dotted) const;
    FilePosition where(std::string dotted, const std::string& path) const;

    nn::Config& config_;
    Table table_;
    std::string path_;                          // of what is being read
    std::map<std::string, FilePosition> seen_;  // dotted key -> where its value stood last
};

}  // namespace mscomp
