// SPDX-License-Identifier: MIT
#pragma once

namespace mscomp {

/// How often something odd was met and at which index first; -1 means never.
struct Occurrences {
    int count = 0;
    int first = -1;

    void add(int index) {
        if (count++ == 0) first = index;
    }
};

}  // namespace mscomp
