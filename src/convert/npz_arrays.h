// SPDX-License-Identifier: MIT
#pragma once

#include <map>
#include <memory>
#include <optional>
#include <set>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "mscomp/convert/npy.h"
#include "mscomp/convert/zip.h"

namespace mscomp {

/// An array and the memory it lies in, where that is not the file itself.
struct OwnedArray {
    std::vector<std::byte> storage;
    NpyArray array;
};

/// The arrays of an .npz by name, read when they are asked for.
class NpzArrays {
  public:
    /// Throws IoError, or InputError if it is no archive.
    explicit NpzArrays(const std::string& path);

    bool contains(const std::string& name) const { return entries_.contains(name); }
    /// How messages call an array: "a.npz[faces]".
    std::string place_of(const std::string& name) const;
    /// Throws InputError if it cannot be read.
    OwnedArray load(const std::string& name);

    /// The name of the array that is called one of `names`, in any case, or else of the only one
    /// that `looks_like_it`, which is noted. Throws InputError if several are called so.
    std::optional<std::string> name_among(std::span<const std::string_view> names,
                                          bool (*looks_like_it)(const NpyArray&),
                                          std::vector<std::string>& notes) const;
    /// "'a' <f4 (3, 4), 'b' (not read)".
    std::string list() const;
    /// Names that were not asked for.
    const std::set<std::string>& left() const { return left_; }
    /// The memory the loaded arrays lie in.
    std::unique_ptr<const std::string> take_file() { return std::move(file_); }

  private:
    OwnedArray unpacked(const std::string& name) const;
    std::optional<OwnedArray> peek(const std::string& name) const;

    std::string path_;
    std::unique_ptr<const std::string> file_;
    std::map<std::string, ZipEntry> entries_;
    std::set<std::string> left_;
};

}  // namespace mscomp
