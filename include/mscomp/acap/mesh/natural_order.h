// SPDX-License-Identifier: MIT
#pragma once

#include <set>
#include <string>
#include <string_view>
#include <vector>

namespace mscomp {

/// "frame_2" before "frame_10": runs of digits compare as numbers, the rest byte by byte.
bool natural_less(std::string_view a, std::string_view b);

/// How the numbers in a set of names are to be read.
struct NumberReading {
    bool decimals = false;          // "1.25" and "1e-05" are one number
    std::set<std::string> negated;  // texts behind which a hyphen is a sign; '#' for each number
};

/// The natural order of a set of paths: folder by folder, then by the stem, then by the extension;
/// what is equal by its numbers goes byte by byte.
///
/// A hyphen before a number is a sign where the set shows it: at the beginning of a name, behind
/// "_", "." or "=", and where the same text stands before a number without one in another name
/// ("f-1" beside "f0"; not "a-1" beside "a-2"). "1.25" is one number where the set shows fractions:
/// numbers without one beside it ("f.1", "f.1.25"), a fraction that begins with 0 or is 0, or a
/// whole part of 0; not where a fraction of several digits ends in 0 beside shorter ones (1.9,
/// 1.10), nor with more points (1.2.10). Exponents are read along with fractions.
class NaturalOrder {
  public:
    explicit NaturalOrder(const std::vector<std::string>& paths);

    void sort(std::vector<std::string>& paths) const;
    bool less(const std::string& a, const std::string& b) const;
    /// Which two paths would change places if numbers such as 1.25 were read the other way, where
    /// the set does not show which one is meant, as a sentence; empty if there is no doubt.
    const std::string& doubt() const { return doubt_; }

  private:
    NumberReading reading_;
    std::string doubt_;
};

}  // namespace mscomp
