// SPDX-License-Identifier: MIT
#include "mscomp/cli/config_file.h"

#include "config_reader.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/nn/kinds.h"

namespace mscomp {

nn::Config default_config(const std::string& kind) {
    nn::Config config = nn::default_config(kind);
    config.data.features = "features.safetensors";
    return config;
}

nn::Config read_config(const std::string& path, const std::vector<std::string>& overrides) {
    return parse_config(read_file(path), path, overrides);
}

nn::Config parse_config(std::string_view yaml, const std::string& path,
                        const std::vector<std::string>& overrides) {
    // Keys and defaults depend on the kind, so it has to be known first.
    const YAML::Node document = load_document(std::string(yaml), path, "YAML");
    nn::Config config = nn::default_config(kind_in(document, overrides));
    ConfigReader reader(config);
    reader.read_document(document, path);
    for (const std::string& text : overrides) reader.read_override(text);
    reader.check(path);
    return config;
}

}  // namespace mscomp
