// SPDX-License-Identifier: MIT
// Reads meshes of one connectivity, extracts their ACAP features, makes meshes of these again and
// prints how far each is from the one that was read: extract_and_decode MESHES...
#include <mscomp/acap/extract.h>
#include <mscomp/acap/mesh/mesh_sequence.h>
#include <mscomp/acap/reconstruct.h>
#include <mscomp/base/error.h>

#include <algorithm>
#include <cmath>
#include <cstdio>

namespace {

double largest_distance(const std::vector<mscomp::Point>& a, const std::vector<mscomp::Point>& b) {
    double largest = 0;
    for (std::size_t i = 0; i < a.size(); ++i) {
        largest = std::max(largest, std::hypot(a[i][0] - b[i][0], a[i][1] - b[i][1],  //
                                               a[i][2] - b[i][2]));
    }
    return largest;
}

void extract_and_decode(const std::vector<std::string>& inputs) {
    const mscomp::MeshSequence meshes = mscomp::read_sequence(mscomp::expand_inputs(inputs));
    const std::vector<mscomp::Point>& reference = meshes.shapes.front();
    const mscomp::ExtractOptions options{.align = false};  // results lie where the input stood
    const mscomp::FeatureSet set = mscomp::extract_features(meshes, reference, options);

    const mscomp::LosslessReconstruction decode(set.reference, options.weights);
    for (int n = 0; n < set.shape_count(); ++n) {
        const std::vector<mscomp::Point>& mesh = meshes.shapes[mscomp::at(n)];
        const mscomp::ReconstructedShape again = decode.solve(set.shape(n), mesh);
        std::printf("%s: comes back within %.2g\n", set.names[mscomp::at(n)].c_str(),
                    largest_distance(again.vertices, mesh));
    }
}

}  // namespace

int main(int argc, char** argv) {
    try {
        extract_and_decode({argv + 1, argv + argc});
        return 0;
    } catch (const mscomp::Error& error) {
        std::fprintf(stderr, "extract_and_decode: %s\n", error.what());
        return static_cast<int>(error.exit_code());
    }
}
