// SPDX-License-Identifier: MIT
#include "mscomp/config/config_file.h"

#include "config_reader.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/file_kind.h"
#include "mscomp/base/path_from.h"
#include "mscomp/base/paths.h"
#include "mscomp/kinds/kinds.h"

namespace mscomp {

std::string config_template(const std::string& kind) {
    Config config = default_config(kind);
    config.data.features = "features.safetensors";
    return write_config(config, true);
}

Config read_config(const std::string& path, const std::vector<std::string>& overrides) {
    const std::string text = read_file(path);
    refuse_other_kinds(text, path);
    return parse_config(text, path, overrides);
}

Config parse_config(std::string_view yaml, const std::string& path,
                    const std::vector<std::string>& overrides) {
    // Keys and defaults depend on the kind, so it has to be known first.
    const YAML::Node document = load_document(std::string(yaml), path, "YAML");
    Config config = default_config(kind_in(document, overrides));
    ConfigReader reader(config);
    reader.read_document(document, path);
    for (const std::string& text : overrides) reader.read_override(text);
    reader.check(path);
    return config;
}

void anchor_paths(Config& config, const std::string& folder) {
    for (std::string* path :
         {&config.data.features, &config.data.split.path, &config.train.start_run}) {
        if (!path->empty()) *path = absolute_path(path_from(folder, *path));
    }
}

}  // namespace mscomp
