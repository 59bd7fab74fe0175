// SPDX-License-Identifier: MIT
#include "mscomp/run/run_folder.h"

#include <filesystem>

#include "mscomp/base/paths.h"

namespace mscomp {
namespace {

std::string in_folder(const std::string& folder, const char* name) {
    return (std::filesystem::path(folder) / name).string();
}

}  // namespace

std::string checkpoint_path(const std::string& run) {
    return in_folder(run, "checkpoint.safetensors");
}
std::string model_path(const std::string& run_or_file) {
    return is_folder(run_or_file) ? checkpoint_path(run_or_file) : run_or_file;
}
std::string milestone_path(const std::string& run) {
    return in_folder(run, "milestone.safetensors");
}
std::string metrics_path(const std::string& run) { return in_folder(run, "metrics.csv"); }
std::string config_path(const std::string& run) { return in_folder(run, "config.yaml"); }
std::string log_path(const std::string& run) { return in_folder(run, "log.txt"); }
std::string lock_path(const std::string& run) { return in_folder(run, ".lock"); }
std::string evaluation_path(const std::string& run) { return in_folder(run, "evaluation.json"); }

}  // namespace mscomp
