// SPDX-License-Identifier: MIT
#include "mscomp/base/error.h"

#include <fmt/format.h>

#include <utility>

#include "mscomp/base/printable.h"

namespace mscomp {

Error::Error(ExitCode exit_code, const std::string& message)
    : std::runtime_error(printable(message)), exit_code_(exit_code) {}

UsageError::UsageError(const std::string& message) : Error(ExitCode::usage, message) {}

std::string at_position(const FilePosition& where, std::string_view message) {
    std::string text = where.path;
    if (where.line > 0) text += fmt::format(":{}", where.line);
    if (where.column > 0) text += fmt::format(":{}", where.column);
    if (!text.empty()) text += ": ";
    return text += printable(message);
}

InputError::InputError(FilePosition where, std::string_view message)
    : Error(ExitCode::invalid_input, at_position(where, message)), where_(std::move(where)) {}

ConfigError::ConfigError(FilePosition where, std::string key, std::string_view message)
    : Error(ExitCode::usage, at_position(where, fmt::format("{}: {}", key, message))),
      where_(std::move(where)),
      key_(std::move(key)) {}

MeshError::MeshError(const std::string& message) : Error(ExitCode::invalid_input, message) {}

IoError::IoError(const std::string& path, std::string_view message)
    : Error(ExitCode::io, fmt::format("{}: {}", path, message)) {}

NumericalError::NumericalError(const std::string& message) : Error(ExitCode::numerical, message) {}

NumericalError::NumericalError(std::string_view op, std::int64_t step, std::string_view tensor)
    : Error(ExitCode::numerical,
            fmt::format("step {}: {} of {} is not finite; nothing was updated", step, tensor, op)) {
}

CheckpointError::CheckpointError(const std::string& path, std::string_view message)
    : Error(ExitCode::checkpoint, fmt::format("{}: {}", path, message)) {}

Interrupted::Interrupted(int signal, const std::string& message)
    : Error(static_cast<ExitCode>(128 + signal), message) {}

}  // namespace mscomp
