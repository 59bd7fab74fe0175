// SPDX-License-Identifier: MIT
#pragma once

#include <array>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/acap/feature_rows.h"
#include "mscomp/acap/placed_features.h"
#include "mscomp/base/shape_features.h"

namespace mscomp {

/// A feature file being written, its rows in any order, so that a set larger than memory can be:
/// features [N,V,9] f32, vertices [N,V,3] f32, reference [V,3] f64, faces [F,3] i32, rotation
/// [N,3,3] f64, translation [N,3] f64, place [V] i32 where not every vertex is a place of its own
/// (VertexPlaces), and where the set has them principal_energy,
/// propagation_energy, relaxation_energy, consistency_energy, consistency_gap, largest_jump,
/// large_jumps, inherent_jumps, removable_jumps [N] f64; metadata: format_version, weights, layout,
/// source, and names and warnings as JSON lists of strings. Without finish() nothing is left
/// behind.
class FeatureFileWriter final : public FeatureRows {
  public:
    /// `outline` (borrowed here only, as are the places of its vertices) has names, reference and
    /// weights, and arrays of N numbers for what finish() will bring; its rows are not looked at.
    /// Throws IoError.
    FeatureFileWriter(const std::string& path, const FeatureSet& outline,
                      const VertexPlaces& places = {});
    ~FeatureFileWriter() override;

    /// Throw IoError, or NumericalError if a number is not finite.
    void put_vertices(int shape, std::span<const float> row) override;
    void put_features(int shape, std::span<const float> row) override;
    void get_features(int shape, std::span<float> row) const override;
    /// Writes everything but the rows and makes the file appear. Warnings that the header has no
    /// room for are counted in one last warning. Throws IoError or NumericalError.
    void finish(const FeatureSet& set);

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// Writes a whole set. Throws IoError, or NumericalError if a number is not finite; then nothing is
/// written.
void write_features(const std::string& path, const FeatureSet& set,
                    const VertexPlaces& places = {});

/// A feature file, memory-mapped: rows are handed out where they lie, and a set larger than memory
/// can be worked with. Read once from end to end when it is opened, which checks everything.
class FeatureFile final : public ShapeSet {
  public:
    /// The numbers per shape and all metadata may be missing (files of other programs); names then
    /// become shape_0000, ... and weights cotangent; without `place` no vertices coincide. Throws
    /// IoError, or InputError for missing tensors, shapes that do not match each other, numbers
    /// that are not finite, faces out of range, and other versions, layouts or weights.
    explicit FeatureFile(const std::string& path);
    FeatureFile(FeatureFile&&) noexcept;
    FeatureFile& operator=(FeatureFile&&) noexcept;
    ~FeatureFile() override;

    const std::string& path() const;
    /// What the file says its data hash to (XXH3); empty for files of other programs.
    std::string data_hash() const;
    int shape_count() const override { return outline().shape_count(); }
    int vertex_count() const override { return outline().vertex_count(); }
    std::span<const float> shape(int index) const override;     // (V,9)
    std::span<const float> vertices(int index) const override;  // (V,3)
    /// Features and vertices of this shape need not stay in memory.
    void forget(int index) const override;
    /// Everything but the rows: `features` and `vertices` are empty.
    const PlacedFeatures& outline() const;

  private:
    struct State;
    std::unique_ptr<State> state_;
};

/// The whole file in memory. Throws as FeatureFile does.
PlacedFeatures read_features(const std::string& path);

}  // namespace mscomp
