// SPDX-License-Identifier: MIT
#pragma once

#include <span>
#include <string>
#include <vector>

#include "mscomp/base/feature_set.h"
#include "mscomp/base/shape_features.h"

namespace mscomp {

/// What codes decode to, a row for each vertex.
enum class ShapeRows {
    features,  // ACAP features (V,9), unscaled
    positions  // (V,3) in the unit of the mesh, where the aligned shapes lie
};

constexpr int row_width(ShapeRows rows) { return rows == ShapeRows::features ? kFeatureDim : 3; }

/// How many components a level has: `components` in each autoencoder, which is one in methods that
/// have none.
struct LevelSize {
    int autoencoders = 1;
    int components = 0;

    int codes() const { return autoencoders * components; }
};

/// How rows change with one code: zero at all vertices but these.
struct CodeColumn {
    std::vector<int> vertices;  // rising
    std::vector<float> values;  // (vertices,row_width)
};

/// Where a component acts by itself.
struct ComponentPlace {
    int center = 0;   // vertex its support lies around
    int longest = 0;  // vertex where it is strongest
    int support = 0;  // vertices where it is not exactly zero; of a joint where it turns, not what
                      // it carries
};

/// How sure a method is of a component.
struct ComponentTrust {
    int votes = 0;           // ways of looking at the shapes that agree on it
    double found_again = 0;  // part of some subsets of the shapes in which it is found again
    double held_out = 0;     // |correlation| of its codes in shapes left out with those read there
                             // by what is found without them; 0 where that is nothing
};

/// Codes (n,K) of n shapes, row after row.
struct CodeTable {
    int code_count = 0;
    std::vector<float> values;

    int shape_count() const {
        return code_count > 0 ? static_cast<int>(values.size()) / code_count : 0;
    }
    std::span<const float> shape(int m) const {
        const auto width = static_cast<std::size_t>(code_count);
        return std::span(values).subspan(static_cast<std::size_t>(m) * width, width);
    }
};

/// Everything that has components, whatever the method: shapes ↔ codes, one code a component.
/// Codes are counted level by level, coarse to fine, within a level autoencoder by autoencoder; who
/// calls sees to it that there are code_count() of them, and no more levels asked for than there
/// are. Vertices are in the order of the user. Synthesis, sampling, export, measures and editing
/// know nothing else of a model.
class ShapeModel {
  public:
    ShapeModel() = default;
    ShapeModel(const ShapeModel&) = delete;
    ShapeModel& operator=(const ShapeModel&) = delete;
    virtual ~ShapeModel() = default;

    virtual ShapeRows rows() const = 0;
    virtual int vertex_count() const = 0;
    /// Coarse to fine, at least one.
    virtual std::vector<LevelSize> levels() const = 0;
    /// Whether every component of a level has an autoencoder of its own on the next one.
    virtual bool refines_components() const { return true; }
    int code_count() const;
    /// For each code that of the component one level coarser which it refines, -1 where there is
    /// none.
    virtual std::vector<int> parents() const;

    /// Codes of shapes `which`; the same bits however they are put together. One call at a time.
    virtual CodeTable encode(const ShapeSet& shapes, std::span<const int> which) = 0;
    /// Codes (K) of the undeformed reference. One call at a time.
    virtual std::vector<float> reference_codes() = 0;

    /// Rows of `codes` (K), of the output of the first `levels` levels, 0 meaning all. Safe to call
    /// from several threads, as are all that follow.
    virtual std::vector<float> decode(std::span<const float> codes, int levels = 0) const = 0;
    /// decode(codes) - decode(from); exactly zero where they are the same.
    virtual std::vector<float> change(std::span<const float> codes,
                                      std::span<const float> from) const = 0;
    /// Derivatives of decode() in every code, (K).
    virtual std::vector<CodeColumn> derivatives(std::span<const float> codes) const = 0;
    /// Of every component, (K).
    virtual std::vector<ComponentPlace> places() const = 0;

    /// Of every component, (K); empty where the method cannot say.
    virtual std::vector<ComponentTrust> trust() const { return {}; }

    /// Size of a change of a row that counts as 1: 1 for features, for positions the radius of the
    /// reference.
    virtual double unit() const { return 1; }
    /// Whether codes drawn from N(0, I) make shapes like those it was trained on.
    virtual bool has_prior() const { return false; }
};

}  // namespace mscomp
