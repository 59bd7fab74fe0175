// SPDX-License-Identifier: MIT
#pragma once

#include <gtest/gtest.h>

#include <string>
#include <typeinfo>

namespace mscomp {

/// The message of the Thrown that `call` throws; a failed expectation and "" if it throws something
/// else or nothing.
template <class Thrown, class Call>
std::string thrown_message(Call&& call) {
    try {
        call();
    } catch (const Thrown& error) {
        return error.what();
    } catch (const std::exception& error) {
        ADD_FAILURE() << "threw " << typeid(error).name() << ": " << error.what();
        return "";
    }
    ADD_FAILURE() << "threw nothing, expected " << typeid(Thrown).name();
    return "";
}

}  // namespace mscomp
