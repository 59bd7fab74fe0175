// SPDX-License-Identifier: MIT
#include "mscomp/base/error.h"
#include "mscomp/convert/splocs_file.h"

namespace mscomp {
namespace {

[[noreturn]] void refuse(const std::string& path) {
    throw UsageError(
        path +
        ": this build has no HDF5; build again where the HDF5 library is installed, or "
        "use .npz");
}

}  // namespace

bool has_hdf5() { return false; }

Contents read_splocs(const std::string& path) { refuse(path); }

void write_splocs(const std::string& path, const ShapeSource&, const ShapesDone&) { refuse(path); }

}  // namespace mscomp
