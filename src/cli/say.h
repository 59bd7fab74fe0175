// SPDX-License-Identifier: MIT
#pragma once

#include <fmt/format.h>

#include <string>
#include <string_view>
#include <type_traits>
#include <utility>

#include "mscomp/base/printable.h"

// The only ways from here to standard output and standard error. What is filled into a message is
// of unknown origin (file names, names in files, option values): it comes out printable and on one
// line, whatever it holds.

namespace mscomp {

/// Lines for standard error. What cannot be written is lost, and nobody is told: no job ends
/// because nobody listens. Results that wait are written first.
void say_lines(std::string_view text) noexcept;

/// Lines for standard output, written at the latest by flush_results. Throws IoError (exit code 4)
/// where the system refuses.
void print_lines(std::string_view text);

/// Throws IoError where results that wait cannot be written.
void flush_results();

/// Writes `text` as it is, waiting for a reader that is slow. Returns 0 or the system's reason.
int write_all(int descriptor, std::string_view text) noexcept;

namespace detail {

/// Texts come out printable, everything else as it is.
template <class T>
decltype(auto) shown(const T& value) {
    if constexpr (std::is_convertible_v<const T&, std::string_view>) {
        return printable(std::string_view(value));
    } else {
        return (value);
    }
}

template <class T>
using Shown = decltype(shown(std::declval<const T&>()));

}  // namespace detail

template <class... T>
using MessageFormat = fmt::format_string<detail::Shown<T>...>;

/// say("acapfeat: warning: {}\n", warning)
template <class... T>
void say(std::type_identity_t<MessageFormat<T...>> format, const T&... values) noexcept {
    try {
        say_lines(fmt::format(format, detail::shown(values)...));
    } catch (const std::exception&) {  // no memory for it
    }
}

/// print_out("{}: {} shapes\n", file, count)
template <class... T>
void print_out(std::type_identity_t<MessageFormat<T...>> format, const T&... values) {
    print_lines(fmt::format(format, detail::shown(values)...));
}

}  // namespace mscomp
