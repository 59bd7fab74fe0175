// SPDX-License-Identifier: MIT
#pragma once

#include <cstddef>
#include <cstdint>
#include <nlohmann/json.hpp>
#include <set>
#include <string>
#include <vector>

namespace mscomp {

/// Sees a text before a tree is made of it: what walks a tree calls itself for every level, and a
/// tree keeps one of two values of a name. What is wrong is up to who derives from it to throw.
class JsonCheck : public nlohmann::json_sax<nlohmann::json> {
  public:
    using Json = nlohmann::json;

    bool null() override { return true; }
    bool boolean(bool) override { return true; }
    bool number_integer(std::int64_t) override { return true; }
    bool number_unsigned(std::uint64_t) override { return true; }
    bool number_float(double, const std::string&) override { return true; }
    bool string(std::string&) override { return true; }
    bool binary(Json::binary_t&) override { return true; }
    bool start_object(std::size_t) override { return open(); }
    bool start_array(std::size_t) override { return open(); }
    bool end_object() override { return close(); }
    bool end_array() override { return close(); }
    bool key(std::string& name) override {
        if (!keys_.back().insert(name).second) fail_repeated(name);
        return true;
    }

  protected:
    explicit JsonCheck(std::size_t most_levels) : most_levels_(most_levels) {}

    [[noreturn]] virtual void fail_repeated(const std::string& name) const = 0;
    [[noreturn]] virtual void fail_deep(std::size_t most_levels) const = 0;

  private:
    bool open() {
        if (keys_.size() == most_levels_) fail_deep(most_levels_);
        keys_.emplace_back();
        return true;
    }
    bool close() {
        keys_.pop_back();
        return true;
    }

    std::size_t most_levels_;
    std::vector<std::set<std::string>> keys_;  // of every object that is open; arrays have none
};

}  // namespace mscomp
