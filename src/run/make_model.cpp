// SPDX-License-Identifier: MIT
#include "make_model.h"

#include "mscomp/acap/edge_weights.h"
#include "mscomp/kinds/kinds.h"

namespace mscomp {

std::unique_ptr<LearnedModel> make_model(const Config& config, const ModelContext& context,
                                         DistanceRows& distances, ModelUse use, int shapes) {
    const ModelPlace place{
        context.reference,
        distances,
        context.scale,
        use,
        shapes,
        [&context] { return ring_weights(context.reference, EdgeWeights::cotangent); },
        context.weights};
    return kind_named(config.kind).make(config, place);
}

}  // namespace mscomp
