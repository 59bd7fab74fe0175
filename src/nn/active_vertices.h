// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <span>
#include <vector>

#include "mscomp/base/index.h"
#include "mscomp/base/mesh_data.h"

namespace mscomp::nn {

/// The vertices that one autoencoder has to touch: those that act, where component weights may
/// differ from zero, and the ring around them, which sees them through the convolution. They are
/// numbered by slots in rising order of the vertices. Everywhere else the output of the autoencoder
/// is the constant tanh(bias of the decoder).
struct ActiveVertices {
    std::vector<int> vertices;         // (slots), rising
    std::vector<int> acting;           // slots that act, rising
    std::vector<int> acting_vertices;  // their vertices
    std::vector<int> ring_offsets;     // (slots+1) into ring_slots
    std::vector<int> ring_slots;       // neighbours that have a slot: all of them where it acts
    std::vector<int> slot_of;          // (V), -1 for vertices without one

    /// `acts` (V), nonzero where a vertex acts.
    static ActiveVertices around(const OneRings& rings, std::span<const std::uint8_t> acts);
    static ActiveVertices all(const OneRings& rings);

    int slot_count() const { return static_cast<int>(vertices.size()); }
    int vertex_count() const { return static_cast<int>(slot_of.size()); }
    bool is_all() const { return vertices.size() == slot_of.size(); }
    bool acts(int vertex) const;
};

/// Those of all autoencoders of a level. Ops that borrow it look at the revision to see that it
/// changed.
class LevelSupports {
  public:
    /// Borrows `rings`; every vertex acts.
    LevelSupports(const OneRings& rings, int autoencoders);

    int count() const { return static_cast<int>(active_.size()); }
    const ActiveVertices& of(int autoencoder) const { return active_[at(autoencoder)]; }
    int revision() const { return revision_; }
    /// `acts` (A,V).
    void set(std::span<const std::uint8_t> acts);

  private:
    const OneRings& rings_;
    std::vector<ActiveVertices> active_;
    int revision_ = 0;
};

}  // namespace mscomp::nn
