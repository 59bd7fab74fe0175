// SPDX-License-Identifier: MIT
#pragma once

#include <string>

namespace CLI {
class App;
}

namespace mscomp {

struct InitOptions {
    std::string kind;
};
void setup_init(CLI::App& app);
void run_init(const InitOptions& options);

}  // namespace mscomp
