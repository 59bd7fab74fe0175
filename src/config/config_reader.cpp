// SPDX-License-Identifier: MIT
#include "config_reader.h"

#include <fmt/format.h>

#include <algorithm>
#include <optional>
#include <set>
#include <utility>

#include "config_values.h"
#include "mscomp/base/nearest_name.h"
#include "mscomp/base/parsed_number.h"
#include "mscomp/kinds/kinds.h"
#include "yaml_documents.h"

namespace mscomp {
namespace {

std::string joined(const std::string& prefix, const std::string& name) {
    return prefix.empty() ? name : prefix + "." + name;
}

// "model.levels[1].components" -> {"model.levels[1]", "components"}
std::pair<std::string, std::string> split_leaf(const std::string& dotted) {
    const std::size_t dot = dotted.rfind('.');
    if (dot == std::string::npos) return {"", dotted};
    return {dotted.substr(0, dot), dotted.substr(dot + 1)};
}

std::string without_index(const std::string& name) { return name.substr(0, name.find('[')); }

// The index in "levels[2]", if there is one.
std::optional<std::size_t> index_of(std::string_view name) {
    const std::size_t open = name.find('[');
    if (open == std::string_view::npos || name.back() != ']') return {};
    return parsed_number<std::size_t>(name.substr(open + 1, name.size() - open - 2));
}

void list_keys(const Table& table, const std::string& prefix, std::vector<std::string>& keys) {
    for (const Key& key : table) {
        const std::string dotted = joined(prefix, key.name);
        keys.push_back(dotted);
        if (const auto* section = std::get_if<Table>(&key.field)) list_keys(*section, dotted, keys);
        if (const auto* list = std::get_if<List>(&key.field)) {
            list_keys(list->sample(), dotted + "[0]", keys);
        }
    }
}

// The same name in another section is nearer than another name in the same section.
std::string nearest_key(const std::string& unknown, const std::vector<std::string>& keys) {
    const auto [prefix, leaf] = split_leaf(unknown);
    const auto distance = [&prefix = prefix, &leaf = leaf](const std::string& key) {
        const auto [key_prefix, key_leaf] = split_leaf(key);
        const bool same_section = without_index(prefix) == without_index(key_prefix);
        return 4 * edit_distance(leaf, key_leaf) + (same_section ? 0 : 3);
    };
    const std::string nearest = *std::min_element(
        keys.begin(), keys.end(),
        [&](const std::string& a, const std::string& b) { return distance(a) < distance(b); });
    const auto [near_prefix, near_leaf] = split_leaf(nearest);
    return without_index(near_prefix) == without_index(prefix) ? joined(prefix, near_leaf)
                                                               : nearest;
}

const Key* find_key(const Table& table, std::string_view name) {
    const auto key = std::find_if(table.begin(), table.end(),
                                  [name](const Key& each) { return each.name == name; });
    return key == table.end() ? nullptr : &*key;
}

constexpr std::size_t kMostBytes = std::size_t{1} << 20;
constexpr int kMostLevels = 16;
constexpr int kMostValues = 100'000;

/// Walks a document once before others do, who call themselves for every level: an alias may stand
/// for what it is in, or for very much. Throws ConfigError.
class TreeCheck {
  public:
    TreeCheck(const std::string& path, const std::string& key) : path_(path), key_(key) {}

    void visit(const YAML::Node& node, int level) {
        if (level > kMostLevels) {
            fail(node, fmt::format("nested deeper than {} levels", kMostLevels));
        }
        if (++values_ > kMostValues) {
            fail(node, fmt::format("more than {} values, aliases written out", kMostValues));
        }
        for (const auto& entry : node) {
            if (node.IsMap()) {
                visit(entry.first, level + 1);
                visit(entry.second, level + 1);
            } else {
                visit(entry, level + 1);
            }
        }
    }

  private:
    [[noreturn]] void fail(const YAML::Node& node, const std::string& what) const {
        throw ConfigError(position_of(node, path_), key_, what);
    }

    const std::string& path_;
    const std::string& key_;
    int values_ = 0;
};

/// What `node` names as model.kind, if it is a known kind.
std::optional<std::string> known_kind(const YAML::Node& model) {
    if (!model.IsMap() || !model["kind"] || !model["kind"].IsScalar()) return {};
    const std::string kind = model["kind"].Scalar();
    const std::vector<std::string> kinds = kind_names();
    return std::ranges::find(kinds, kind) != kinds.end() ? std::optional(kind) : std::nullopt;
}

}  // namespace

YAML::Node load_document(std::string yaml, const std::string& path, const std::string& key) {
    if (yaml.size() > kMostBytes) {
        throw ConfigError({path}, key,
                          fmt::format("{} bytes, wanted at most {}", yaml.size(), kMostBytes));
    }
    // yaml-cpp 0.7 misses a quote that is never closed if a line break ends the text.
    yaml.erase(yaml.find_last_not_of(" \t\r\n") + 1);
    try {
        require_one_document(yaml, path, key);
        const YAML::Node document = YAML::Load(yaml);
        TreeCheck(path, key).visit(document, 0);
        return document;
    } catch (const YAML::Exception& error) {
        const YAML::Mark& mark = error.mark;
        throw ConfigError(mark.is_null() ? FilePosition{path, 0, 0}
                                         : FilePosition{path, mark.line + 1, mark.column + 1},
                          key, fmt::format("not valid YAML: {}", error.msg));
    }
}

std::string kind_in(const YAML::Node& root, const std::vector<std::string>& overrides) {
    std::string kind = kind_names().front();
    if (root.IsMap() && root["model"]) kind = known_kind(root["model"]).value_or(kind);
    for (const std::string& text : overrides) {
        YAML::Node model;
        if (text.starts_with("model.kind=")) {
            model["kind"] = text.substr(text.find('=') + 1);
        } else if (text.starts_with("model=")) {
            model = load_document(text.substr(text.find('=') + 1), "--set " + text, "model");
        }
        kind = known_kind(model).value_or(kind);
    }
    return kind;
}

std::optional<std::string> kind_in(const Setting& setting) {
    if (setting.key == "model") return known_kind(setting.value);
    if (setting.key != "model.kind") return {};
    YAML::Node model;
    model["kind"] = setting.value;
    return known_kind(model);
}

void ConfigReader::read_document(const YAML::Node& root, const std::string& path) {
    path_ = path;
    if (root.IsNull()) return;
    if (!root.IsMap()) {
        throw ConfigError(position_of(root, path), "configuration",
                          fmt::format("got {}, wanted a mapping with the keys model, loss, data, "
                                      "train, filter",
                                      found(root)));
    }
    read_table(table_, root, "", false);
}

void ConfigReader::read_override(const std::string& text) {
    path_ = "--set " + text;
    const std::size_t equals = text.find('=');
    if (equals == std::string::npos || equals == 0) {
        throw ConfigError({path_}, text, "wanted key=value, e.g. train.epochs=100");
    }
    const std::string dotted = text.substr(0, equals);
    const Key key = find(dotted, {path_});
    const YAML::Node value = load_document(text.substr(equals + 1), path_, dotted);
    read_field(key, value, dotted);
}

void ConfigReader::read_setting(const Setting& setting) {
    path_ = setting.where.path;
    read_field(find(setting.key, setting.where), setting.value, setting.key);
}

void ConfigReader::check(const std::string& path) const {
    if (config_.data.features.empty()) {
        throw ConfigError(where("data.features", path), "data.features",
                          "missing; it names the file made by acapfeat extract");
    }
    const SplitConfig& split = config_.data.split;
    if (split.train == SplitKind::random && split.count == 0) {
        throw ConfigError(where("data.split.count", path), "data.split.count",
                          "missing; `train: random` wants the number of training shapes, >= 1");
    }
    if (split.train == SplitKind::file && split.path.empty()) {
        throw ConfigError(where("data.split.path", path), "data.split.path",
                          "missing; `train: file` wants a file of shape indices");
    }
}

void ConfigReader::read_field(const Key& key, const YAML::Node& node, const std::string& dotted) {
    // Values of --set have no line of their own: the option itself is the place.
    seen_[dotted] = path_.starts_with("--set ") ? FilePosition{path_} : position_of(node, path_);
    if (const auto* section = std::get_if<Table>(&key.field); section && node.IsMap()) {
        read_table(*section, node, dotted, false);
        return;
    }
    if (const auto* list = std::get_if<List>(&key.field);
        list && node.IsSequence() && node.size() > 0) {
        read_list(*list, node, dotted);
        return;
    }
    if (read_value(key, node)) return;
    std::string message = fmt::format("got {}, wanted {}", found(node), wanted(key));
    if (const auto* choice = std::get_if<Choice>(&key.field); choice && node.IsScalar()) {
        message += fmt::format("; the nearest is {}", nearest_name(node.Scalar(), choice->names));
    }
    throw ConfigError(seen_[dotted], dotted, message);
}

void ConfigReader::read_table(const Table& table, const YAML::Node& node, const std::string& dotted,
                              bool is_new_entry) {
    std::set<std::string> names;
    for (const auto& entry : node) {
        const bool is_set = path_.starts_with("--set ");
        const FilePosition here = is_set ? FilePosition{path_} : position_of(entry.first, path_);
        const std::string name = entry.first.IsScalar() ? entry.first.Scalar() : found(entry.first);
        const std::string full = joined(dotted, name);
        const Key* key = find_key(table, name);
        if (key == nullptr) fail_unknown(here, full);
        if (!names.insert(name).second) {
            throw ConfigError(here, full, "given twice; wanted once");
        }
        read_field(*key, entry.second, full);
    }
    for (const Key& key : table) {
        if (is_new_entry && key.required && !names.contains(key.name)) {
            throw ConfigError(where(dotted, path_), joined(dotted, key.name),
                              fmt::format("missing; wanted {}", wanted(key)));
        }
    }
}

void ConfigReader::read_list(const List& list, const YAML::Node& node, const std::string& dotted) {
    list.replace(node.size());
    for (std::size_t i = 0; i < node.size(); ++i) {
        const std::string entry = fmt::format("{}[{}]", dotted, i);
        const Key key{entry, list.entry(i), {}, ""};
        seen_[entry] = position_of(node[i], path_);
        if (!node[i].IsMap()) read_field(key, node[i], entry);
        read_table(std::get<Table>(key.field), node[i], entry, true);
    }
}

Key ConfigReader::find(std::string_view dotted, const FilePosition& where) const {
    Key key{"", table_, {}, ""};
    std::size_t begin = 0;
    while (begin <= dotted.size()) {
        const std::size_t end = std::min(dotted.find('.', begin), dotted.size());
        const std::string_view name = dotted.substr(begin, end - begin);
        const auto* section = std::get_if<Table>(&key.field);
        const Key* next = section ? find_key(*section, name.substr(0, name.find('['))) : nullptr;
        if (next == nullptr) fail_unknown(where, std::string(dotted));
        key = Key(*next);
        if (name.find('[') != std::string_view::npos) {
            const auto* list = std::get_if<List>(&key.field);
            const std::optional<std::size_t> index = index_of(name);
            if (list == nullptr) fail_unknown(where, std::string(dotted));
            if (!index || *index >= list->size()) {
                throw ConfigError(where, std::string(dotted),
                                  fmt::format("no such {}; there are {}, numbered from 0",
                                              list->entries, list->size()));
            }
            key.field = Table(list->entry(*index));
        }
        begin = end + 1;
    }
    return key;
}

void ConfigReader::fail_unknown(FilePosition where, const std::string& dotted) const {
    std::vector<std::string> keys;
    list_keys(table_, "", keys);
    for (const std::string& kind : kind_names()) {
        Config other = default_config(kind);
        std::vector<std::string> others;
        list_keys(config_table(other), "", others);
        if (std::ranges::find(others, dotted) == others.end()) continue;
        throw ConfigError(
            std::move(where), dotted,
            fmt::format("a key of the kind {}; this is a configuration of the kind {}", kind,
                        config_.kind));
    }
    throw ConfigError(
        std::move(where), dotted,
        fmt::format("unknown key; the nearest known key is {}", nearest_key(dotted, keys)));
}

FilePosition ConfigReader::where(std::string dotted, const std::string& path) const {
    while (!dotted.empty()) {
        if (const auto place = seen_.find(dotted); place != seen_.end()) return place->second;
        dotted = split_leaf(dotted).first;
    }
    return {path};
}

}  // namespace mscomp
