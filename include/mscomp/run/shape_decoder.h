// SPDX-License-Identifier: MIT
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "mscomp/acap/feature_file.h"
#include "mscomp/acap/surface_shapes.h"
#include "mscomp/edit/code_positions.h"
#include "mscomp/edit/vertex_fit.h"
#include "mscomp/run/trained_run.h"

namespace mscomp {

/// A shape as a model gives it back.
struct DecodedShape {
    std::vector<float> codes;     // (K) of all levels
    std::vector<float> rows;      // of the model
    std::vector<Point> vertices;  // (W)
};

/// Turns shapes of a feature file into what a run makes of them, a few at a time: the same bits for
/// any number of threads and however shapes are put together.
class ShapeDecoder {
  public:
    /// Shapes worth handing over together; runs are to be opened for batches of so many.
    static constexpr int kGroup = 32;

    /// Borrows the run and the file, which must be of its mesh (require_mesh_of). `check_stop` is
    /// called before every shape, perhaps from several threads, and may throw; it may be empty.
    ShapeDecoder(TrainedRun& run, const FeatureFile& file, std::function<void()> check_stop);
    /// The same with another model in place of the one of the run, made of that; `codes` are its
    /// codes of the training shapes.
    ShapeDecoder(TrainedRun& run, ShapeModel& model, CodeTable codes, const FeatureFile& file,
                 std::function<void()> check_stop);

    /// Codes of the training shapes.
    const CodeTable& training_codes() const { return training_codes_; }

    /// The vertices of a shape of the file on the places of the run, (W), as are all below.
    std::vector<Point> truth(int shape) const { return points_of(shapes_.vertices(shape)); }

    /// The same where the shape lay before it was aligned to the reference.
    std::vector<Point> truth_in_place(int shape) const;

    /// Features fit: the codes of the model's encoder, vertices without loss; of the output of the
    /// first `levels` levels, 0 meaning all.
    std::vector<DecodedShape> encode(std::span<const int> shapes, int levels = 0);
    /// What codes (K) for each of the shapes decode to, vertices without loss.
    std::vector<DecodedShape> decode(std::span<const int> shapes,
                                     std::vector<std::vector<float>> codes, int levels = 0) const;
    /// Vertices fit: codes whose vertices are nearest to those of each shape. Steps go by the
    /// Poisson solve; where that ends farther away than the start, as it may if the start is nearly
    /// exact, by the lossless one. So it never ends farther away. With a list of known vertices it
    /// looks at nothing else, and Poisson it is, with a stronger prior.
    std::vector<DecodedShape> fit(std::span<const int> shapes, std::span<const DecodedShape> starts,
                                  const FitSubset& subset = {});
    /// Joint codes: those whose features are nearest to those of each shape, each channel scaled as
    /// for training, each vertex counting as it does there; only the codes `moving` move, empty
    /// meaning all. Vertices without loss. Throws UsageError if the model does not decode to
    /// features.
    std::vector<DecodedShape> fit_features(std::span<const int> shapes,
                                           std::span<const DecodedShape> starts,
                                           std::span<const int> moving = {}) const;
    /// Positions of codes as the steps of fit() see them, (W).
    std::vector<Point> positions(std::span<const float> codes);

    /// [A] eq. 8; none where the model does not decode to features, and for a shape with those of
    /// the reference, which has no deformation to measure by.
    std::optional<double> relative_squared_error_of(int shape, const DecodedShape& decoded) const;
    /// That of the undeformed reference: what a result has to stay below to be worth anything.
    std::optional<double> relative_squared_error_of_reference(int shape) const;

  private:
    std::optional<double> relative_squared_error_of(int shape, std::vector<float> rows) const;
    const VertexFit& made(std::unique_ptr<VertexFit>& fit, VertexFitOptions options);

    TrainedRun& run_;
    ShapeModel& model_;
    CodeTable training_codes_;
    const FeatureFile& file_;
    SurfaceShapes shapes_;
    std::function<void()> check_stop_;
    CodePositions lossless_;
    std::unique_ptr<VertexFit> poisson_fit_, handle_fit_, lossless_fit_;  // made when first needed
};

/// Throws InputError if the file has another mesh than the run.
void require_mesh_of(const TrainedRun& run, const FeatureFile& file);

/// The shapes of `file` in a split of the run: all, train or test. Throws UsageError (no shapes) or
/// InputError (the file has fewer).
std::vector<int> shapes_of_split(const TrainedRun& run, const FeatureFile& file,
                                 const std::string& split);

}  // namespace mscomp
