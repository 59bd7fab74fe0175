// SPDX-License-Identifier: MIT
#pragma once

#include <nlohmann/json.hpp>
#include <span>
#include <vector>

#include "mscomp/eval/measures.h"
#include "mscomp/model/components.h"
#include "mscomp/run/fits.h"
#include "mscomp/run/shape_decoder.h"

namespace mscomp {

/// E_rms of the same shapes for several numbers of something.
struct ErrorCurve {
    std::vector<int> numbers;
    std::vector<RmsError> errors;  // of each

    /// Throws UsageError naming `option` for numbers that are not in `least` .. `most`.
    ErrorCurve(std::vector<int> of, const char* option, int least, int most,
               const std::vector<Point>& reference);
    /// [{"n", "rms_error"}, ...]
    nlohmann::ordered_json json() const;
};

/// E_rms against how many components may act: those that move
/// the shape most, while all other codes stay at
/// those of the reference.
class ComponentCurve {
  public:
    /// Throws UsageError for more components than there are.
    ComponentCurve(const std::vector<int>& numbers, const std::vector<Component>& components,
                   const std::vector<Point>& reference, std::vector<Fit> fits);
    /// Shapes with what encode() gives for them.
    void add(ShapeDecoder& decoder, std::span<const int> shapes,
             std::span<const DecodedShape> encoded);
    /// Of each of the fits.
    const std::vector<ErrorCurve>& errors() const { return errors_; }

  private:
    std::vector<float> reference_codes_;  // (K)
    std::vector<int> farthest_first_;     // (K) codes, in the ranking of the components
    std::vector<int> numbers_;
    std::vector<Fit> fits_;
    std::vector<ErrorCurve> errors_;
};

/// E_rms against how many vertices of a shape are known: farthest-point samples of the reference.
/// Codes start from those of the training shape (or reference) that is nearest at these vertices
/// and are fitted to them alone.
class HandleCurve {
  public:
    /// `codes` are those of the training shapes. Throws UsageError for fewer than 3 handles, which
    /// leave open how a shape is turned, or more than vertices.
    HandleCurve(const std::vector<int>& numbers, const TrainedRun& run, const CodeTable& codes,
                const std::vector<Component>& components);
    void add(ShapeDecoder& decoder, std::span<const int> shapes);
    const ErrorCurve& errors() const { return errors_; }

  private:
    struct Start {
        std::vector<float> codes;
        std::vector<Point> handles;  // where they put the handles
    };
    void place_starts(ShapeDecoder& decoder);
    const std::vector<float>& nearest_start(const std::vector<Point>& truth) const;

    std::vector<int> handles_;
    std::vector<Start> starts_;
    bool is_placed_ = false;
    ErrorCurve errors_;
};

}  // namespace mscomp
