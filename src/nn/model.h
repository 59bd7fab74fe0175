// SPDX-License-Identifier: MIT
#pragma once

#include <cstdint>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "mscomp/base/distance_rows.h"
#include "mscomp/base/mesh_data.h"
#include "mscomp/model/shape_model.h"
#include "mscomp/nn/config.h"
#include "nn/code_decoder.h"
#include "nn/lane_batch.h"
#include "nn/ops.h"
#include "nn/parameter_set.h"
#include "nn/tape.h"
#include "nn/vertex_order.h"

namespace mscomp::nn {

/// What every model kind is to the trainer, to model files, to the components and to the measures.
/// A kind records its loss on the tape and says what its codes are; a batch, parameters and the
/// numbering of the vertices are the same for all. All arrays that come in or go out are in the
/// vertex order of the user; inside, vertices are in reverse Cuthill-McKee order.
template <class T>
class Model {
  public:
    Model(const Model&) = delete;
    Model& operator=(const Model&) = delete;
    virtual ~Model() = default;

    const VertexOrder& order() const { return order_; }
    int vertex_count() const { return order_.vertex_count(); }
    int batch_capacity() const { return batch_; }
    ParameterSet<T>& parameters() { return parameters_; }
    const ParameterSet<T>& parameters() const { return parameters_; }
    Tape<T>& tape() { return tape_; }
    /// Distances in inner numbering.
    DistanceRows& inner_distances() { return inner_distances_; }

    /// Makes shapes `which` of `features` (N,V,9) the batch; scaled features, at least one shape
    /// and at most the capacity.
    template <class Source>
    void load_batch(std::span<const Source> features, std::span<const int> which);
    /// The same from features that lie elsewhere and are not scaled yet.
    void load_batch(const ScaledFeatures& features, std::span<const int> which);
    /// A batch that was gathered in order() for lane_count(batch_capacity()) lanes.
    void load_batch(const LaneBatch& batch);

    /// |x|^2 of a shape, mean over the batch: the error of a model that gives back zeros.
    double input_energy();

    /// Runs the batch; returns the total loss.
    T forward();
    /// Gradients of the last forward pass, added to those of the parameters.
    void backward();
    /// Both, perhaps faster, with the same result; nothing can be read in between, and afterwards
    /// there may be no reconstruction.
    virtual T forward_and_backward();

    /// What the terms of the loss are called, and their values after a pass, before their weights.
    virtual std::vector<std::string> term_names() const = 0;
    virtual std::vector<double> term_values() = 0;
    /// Share of vertices that a pass touches in an autoencoder of the last level.
    virtual double touched() const { return 1; }

    /// Parameters to begin with, from the shapes to train on or at random.
    virtual void start(const TrainConfig& train, const ScaledFeatures& features,
                       std::span<const int> shapes) = 0;
    /// What a step needs besides the batch; a function of seed and step alone. Steps count from 1.
    virtual void prepare_step(std::uint64_t /*seed*/, std::int64_t /*step*/) {}
    /// Parameters after step `step` from their gradients.
    virtual void update(const TrainConfig& train, double rate, std::int64_t step) = 0;

    /// Coarse to fine.
    virtual std::vector<LevelSize> level_sizes() const = 0;
    /// Whether every component of a level has an autoencoder of its own on the next one.
    virtual bool refines_components() const { return true; }
    /// The component weights of a level, an entry (A,K,V,d) of parameters().
    virtual int component_weights(int level) const = 0;
    /// Centre vertex of every component of a level, (A*K); empty or -1 before the first pass.
    virtual std::vector<int> centers(int level) const = 0;
    virtual void set_centers(int level, std::vector<int> user) = 0;
    /// Codes of a level after forward, (n, A*K).
    virtual std::vector<T> codes(int level) = 0;
    /// Codes of all levels side by side, (n,K).
    std::vector<T> all_codes();
    /// Sum of the outputs of the first `levels` levels after forward and before backward, (n,V,9).
    virtual std::vector<T> reconstruction(int levels) = 0;
    /// The decoder of all codes with the parameters of this moment, which it copies.
    virtual std::unique_ptr<CodeDecoder> decoder() const = 0;

    /// Vertices that act, as far as steps decide about them, to be saved with the parameters; none
    /// for most kinds. Restoring checks them: false if component weights would be left out.
    virtual std::vector<std::uint8_t> acting_vertices() const { return {}; }
    virtual bool restore_acting_vertices(std::span<const std::uint8_t> acting) {
        return acting.empty();
    }

    /// A parameter-sized array of entry `index` in the vertex order of the user, and back.
    std::vector<T> to_user_order(int index, std::span<const T> inner) const;
    void from_user_order(int index, std::span<const T> user, std::span<T> inner) const;
    /// Gradient of the batch after backward, (n,V,9), if it was asked for.
    std::vector<T> input_gradient() { return batch_rows(tape_.grad(x_)); }

  protected:
    /// A model for batches of at most `batch` shapes of a mesh with these one-rings.
    Model(const OneRings& rings, DistanceRows& distances, int batch);

    /// Records the tensor x (1,V,9,lanes) that batches are loaded into; once, after the parameters,
    /// whose memory the tape borrows. `total_` is for the kind to record.
    Var record_input(bool with_gradient);
    /// Adds component weights (A,K,V,d). Rows start with unit length, so that an entry is about
    /// 1/sqrt(V), and Adam's steps are of the size of the rate whatever the gradient: on fine
    /// meshes they have to shrink as well, to the power `exponent` of 1/sqrt(V).
    int add_component_weights(std::string name, Extents extents, double exponent = 1);
    /// Called after a batch was loaded.
    virtual void batch_loaded(std::span<const int> /*shapes*/) {}

    int lanes() const { return static_cast<int>(lane_mask_.weight.size()); }
    /// Numbers (rows,lanes) of the lanes with shapes, as (n,rows).
    std::vector<T> batch_codes(std::span<const T> codes) const;
    /// Rows (V,9,lanes) of the lanes with shapes, as (n,V,9).
    std::vector<T> batch_rows(std::span<const T> rows) const;

    VertexOrder order_;
    ReorderedDistances inner_distances_;
    int batch_;
    LaneMask<T> lane_mask_;
    ParameterSet<T> parameters_;
    Tape<T> tape_;
    Var x_, total_;

  private:
    void set_shapes(std::span<const int> shapes);
};

}  // namespace mscomp::nn
