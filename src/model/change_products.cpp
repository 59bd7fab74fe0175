// SPDX-License-Identifier: MIT
#include "model/change_products.h"

#include <algorithm>

#include "mscomp/base/index.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Changes of a block of vertices as columns, without those of components that leave it alone.
struct BlockOfChanges {
    std::vector<Index> acting;
    MatrixXd columns;  // (rows · width, acting)
};

BlockOfChanges changes_at(const std::vector<Component>& components, std::size_t first,
                          std::size_t end, std::size_t width, const MetricScale* metric) {
    BlockOfChanges block;
    block.columns.resize(static_cast<Index>((end - first) * width),
                         static_cast<Index>(components.size()));
    for (std::size_t k = 0; k < components.size(); ++k) {
        const Component& c = components[k];
        const double range = c.code_end - c.code_other;
        if (range == 0) continue;
        const auto column = static_cast<Index>(block.acting.size());
        bool acts = false;
        for (std::size_t i = first * width; i < end * width; ++i) {
            const double change = (static_cast<double>(c.difference[i]) -
                                   static_cast<double>(c.other_difference[i])) /
                                  range;
            acts = acts || change != 0;
            block.columns(static_cast<Index>(i - first * width), column) =
                metric == nullptr ? change : change * metric->scale_factor(i / width, i % width);
        }
        if (acts) block.acting.push_back(static_cast<Index>(k));
    }
    return block;
}

}  // namespace

MatrixXd change_products(const std::vector<Component>& components, int width,
                         const MetricScale* metric) {
    constexpr std::int64_t kBlock = 64, kMostSums = 16;
    const auto count = static_cast<Index>(components.size());
    if (components.empty()) return {};
    const std::size_t row = at(width);
    const Chunks blocks{static_cast<std::int64_t>(components.front().difference.size() / row),
                        kBlock};
    // Few sums, whatever the number of threads.
    const Chunks chunks{blocks.count(), (blocks.count() + kMostSums - 1) / kMostSums};
    std::vector<MatrixXd> parts(at(chunks.count()));
    parallel_for(chunks.count(), [&](std::int64_t i) {
        MatrixXd& part = parts[at(i)];
        part.setZero(count, count);
        for (std::int64_t b = chunks.begin(i); b < chunks.end(i); ++b) {
            const BlockOfChanges block =
                changes_at(components, at(blocks.begin(b)), at(blocks.end(b)), row, metric);
            const auto acting = static_cast<Index>(block.acting.size());
            const auto columns = block.columns.leftCols(acting);
            const MatrixXd products = columns.transpose() * columns;
            for (Index a = 0; a < acting; ++a) {
                for (Index c = 0; c < acting; ++c) {
                    part(block.acting[at(a)], block.acting[at(c)]) += products(a, c);
                }
            }
        }
    });
    MatrixXd sum = MatrixXd::Zero(count, count);
    for (const MatrixXd& part : parts) sum += part;
    return sum;
}

}  // namespace mscomp
