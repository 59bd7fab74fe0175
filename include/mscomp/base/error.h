// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <stdexcept>
#include <string>
#include <string_view>

namespace mscomp {

/// What a command returns to the shell.
enum class ExitCode : int {
    ok = 0,
    bug = 1,
    usage = 2,
    invalid_input = 3,
    io = 4,
    numerical = 5,
    checkpoint = 6,
    interrupted = 130,
    terminated = 143
};

/// Base of everything this project throws: one sentence for the user and the exit code it leads to.
class Error : public std::runtime_error {
  public:
    Error(ExitCode exit_code, const std::string& message);
    ExitCode exit_code() const { return exit_code_; }

  private:
    ExitCode exit_code_;
};

/// A command line that cannot be carried out (unknown option, output exists, nothing matches).
class UsageError : public Error {
  public:
    explicit UsageError(const std::string& message);
};

/// A place in a file the user gave; line and column count from 1, 0 means "the file as a whole".
struct FilePosition {
    std::string path;
    std::int64_t line = 0;
    std::int64_t column = 0;
};

/// "path:line:column: message", leaving out what is 0; control characters in the message become
/// '?'.
std::string at_position(const FilePosition& where, std::string_view message);

/// A file that is not what it has to be: "swing/frame_0007.obj:1203: face refers to vertex 9001,
/// ...".
class InputError : public Error {
  public:
    InputError(FilePosition where, std::string_view message);
    const FilePosition& where() const { return where_; }

  private:
    FilePosition where_;
};

/// A configuration that cannot be used; `key` is the dotted path, e.g.
/// "model.levels[0].components".
class ConfigError : public Error {
  public:
    ConfigError(FilePosition where, std::string key, std::string_view message);
    const FilePosition& where() const { return where_; }
    const std::string& key() const { return key_; }

  private:
    FilePosition where_;
    std::string key_;
};

/// Meshes that parse but cannot be worked with together or at all.
class MeshError : public Error {
  public:
    explicit MeshError(const std::string& message);
};

/// The system refused to read or write: path and the system's own reason.
class IoError : public Error {
  public:
    IoError(const std::string& path, std::string_view message);
};

/// A value that is not finite or a solve that failed.
class NumericalError : public Error {
  public:
    explicit NumericalError(const std::string& message);
    /// Training: which tensor of which operation, at which step.
    NumericalError(std::string_view op, std::int64_t step, std::string_view tensor);
};

/// A checkpoint that is truncated, altered or of another model.
class CheckpointError : public Error {
  public:
    CheckpointError(const std::string& path, std::string_view message);
};

/// Stopped by SIGINT (130) or SIGTERM (143) after everything worth keeping was saved.
class Interrupted : public Error {
  public:
    Interrupted(int signal, const std::string& message);
};

}  // namespace mscomp
