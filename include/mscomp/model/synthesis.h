// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mscomp/model/components.h"
#include "mscomp/model/shape_model.h"

namespace mscomp {

/// How far a component goes: 0 the reference, 1 its end, below 0 away from it.
struct ComponentWeight {
    int code = 0;  // Component::code
    double weight = 0;
};

/// Shapes made of the components of a model, [B] eq. 14. Borrows the model.
class Synthesis {
  public:
    /// All components of the model, as extract_components gives them.
    Synthesis(const ShapeModel& model, const std::vector<Component>& components);

    /// z_i = z_r,i + W_i (z_end,i - z_r,i) for the components of `weights`, z_r,i for all others:
    /// (code_count()). A weight of 0 or 1 gives exactly z_r,i or z_end,i. What was merged into a
    /// component moves along with it.
    std::vector<float> codes(std::span<const ComponentWeight> weights) const;
    /// What `codes` change: Dec(z) - Dec(z_r) in the rows of the model. At the end of one component
    /// alone the same bits as Component::difference.
    std::vector<float> change(std::span<const float> codes) const;

  private:
    const ShapeModel& model_;
    std::vector<float> reference_, end_;  // codes
    std::vector<Component> moving_;       // what put_at needs of each
};

/// Where the codes of random shapes come from.
enum class CodeDistribution {
    prior,       // N(0, I), what a variational autoencoder is trained for
    fitted,      // the Gaussian with mean and covariance of the training codes
    independent  // the same with the variances only: every code by itself
};

/// Random codes of whole shapes. Draw `index` is a function of seed and index alone.
class CodeSampler {
  public:
    /// `codes` are those of the training shapes, of at least two unless the prior is asked for;
    /// throws UsageError otherwise. The covariance is that of n - 1 degrees of freedom.
    CodeSampler(CodeDistribution distribution, const CodeTable& codes, std::uint64_t seed);

    /// All codes of one shape, counted as ShapeModel does. With fewer shapes than codes the
    /// covariance is singular, but z = mean + sum_m w_m (z_m - mean) / sqrt(n - 1) with
    /// w ~ N(0, I) has exactly that covariance and stays in the span of the training shapes.
    std::vector<float> draw(std::uint64_t index) const;

  private:
    CodeDistribution distribution_;
    std::uint64_t seed_;
    std::size_t width_ = 0;           // codes of a shape
    std::vector<double> mean_;        // (width)
    std::vector<double> deviations_;  // fitted: (n,width) over sqrt(n - 1); independent: (width)
};

}  // namespace mscomp
