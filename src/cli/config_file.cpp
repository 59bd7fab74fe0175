// SPDX-License-Identifier: MIT
#include "mscomp/cli/config_file.h"

#include <fmt/format.h>

#include "config_reader.h"
#include "mscomp/base/atomic_file.h"
#include "mscomp/base/error.h"
#include "mscomp/cli/nearest_name.h"

namespace mscomp {

nn::Config default_config(const std::string& kind) {
    const std::vector<std::string> kinds = model_kinds();
    for (const std::string& known : kinds) {
        if (kind != known) continue;
        nn::Config config;
        config.model.kind = kind;
        config.data.features = "features.safetensors";
        return config;
    }
    throw UsageError(
        fmt::format("unknown model kind \"{}\"; known kinds: {}", kind, fmt::join(kinds, ", ")));
}

nn::Config read_config(const std::string& path, const std::vector<std::string>& overrides) {
    return parse_config(read_file(path), path, overrides);
}

nn::Config parse_config(std::string_view yaml, const std::string& path,
                        const std::vector<std::string>& overrides) {
    nn::Config config;
    ConfigReader reader(config);
    reader.read_document(yaml, path);
    for (const std::string& text : overrides) reader.read_override(text);
    reader.check(path);
    return config;
}

}  // namespace mscomp
