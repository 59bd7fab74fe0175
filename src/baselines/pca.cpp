// SPDX-License-Identifier: MIT
// The kind `pca`: the mean of the aligned training shapes plus their first principal directions.
#include <Eigen/Core>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <memory>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/points.h"
#include "mscomp/base/safetensors.h"
#include "mscomp/model/counts.h"
#include "mscomp/model/kind.h"
#include "mscomp/model/stored_arrays.h"

namespace mscomp {
namespace {

using Eigen::MatrixXd;
using Eigen::VectorXd;

struct PcaSettings {
    int components = 50;  // as many as the training shapes span, if these are fewer
};

/// x = mean + Σ_k z_k C_k over positions x (3V), C_k of unit length, the one along which the
/// training shapes vary most first; z_k = C_k · (x - mean).
class Pca final : public LearnedModel {
  public:
    Pca(int components, const TriangleMesh& reference)
        : components_(components), reference_(reference) {}

    ShapeRows rows() const override { return ShapeRows::positions; }
    int vertex_count() const override { return reference_.vertex_count(); }
    std::vector<LevelSize> levels() const override { return {{1, components_}}; }
    double unit() const override {
        const double scale = unit_ball_scale(reference_.vertices);
        return scale > 0 ? 1 / scale : 1;
    }

    CodeTable encode(const ShapeSet& shapes, std::span<const int> which) override {
        CodeTable table{components_, {}};
        for (const int shape : which) {
            const std::span<const float> x = shapes.vertices(shape);
            append(table, Eigen::Map<const Eigen::VectorXf>(x.data(), size()).cast<double>());
        }
        return table;
    }
    std::vector<float> reference_codes() override {
        CodeTable table{components_, {}};
        append(table, Eigen::Map<const VectorXd>(reference_.vertices.front().data(), size()));
        return table.values;
    }
    std::vector<float> decode(std::span<const float> codes, int /*levels*/) const override {
        return to_floats(mean_ + directions_ * vector_of(codes));
    }
    std::vector<float> change(std::span<const float> codes,
                              std::span<const float> from) const override {
        return to_floats(directions_ * (vector_of(codes) - vector_of(from)));
    }
    std::vector<CodeColumn> derivatives(std::span<const float> /*codes*/) const override {
        std::vector<CodeColumn> columns(at(components_));
        for (int k = 0; k < components_; ++k) {
            columns[at(k)].values = to_floats(directions_.col(k));
            for (int v = 0; v < vertex_count(); ++v) columns[at(k)].vertices.push_back(v);
        }
        return columns;
    }
    std::vector<ComponentPlace> places() const override {
        std::vector<ComponentPlace> places;
        for (int k = 0; k < components_; ++k) {
            const VectorXd lengths =
                Eigen::Map<const MatrixXd>(directions_.col(k).data(), 3, vertex_count())
                    .colwise()
                    .norm();
            ComponentPlace place;
            lengths.maxCoeff(&place.longest);
            place.center = place.longest;
            place.support = static_cast<int>((lengths.array() > 0).count());
            places.push_back(place);
        }
        return places;
    }

    std::unique_ptr<Learner> learner(const ShapeSet& shapes, std::span<const int> train) override;
    void save(StoredArrays& arrays) const override {
        arrays.keep<double>("pca/mean", {vertex_count(), 3}, {mean_.begin(), mean_.end()});
        arrays.keep<double>("pca/directions", {components_, vertex_count(), 3},
                            {directions_.data(), directions_.data() + directions_.size()});
    }
    void load(const SafetensorsFile& file) override {
        const auto mean = file.data<double>("pca/mean", {vertex_count(), 3});
        const auto directions = file.data<double>("pca/directions", {-1, vertex_count(), 3});
        components_ = static_cast<int>(directions.size() / mean.size());
        mean_ = Eigen::Map<const VectorXd>(mean.data(), size());
        directions_ = Eigen::Map<const MatrixXd>(directions.data(), size(), components_);
    }

    /// The principal directions of the columns of `shapes` (3V,n) by the eigenvectors of their Gram
    /// matrix. Returns the mean square of a coordinate that is left.
    double fit(MatrixXd shapes) {
        mean_ = shapes.rowwise().mean();
        shapes.colwise() -= mean_;
        const Eigen::SelfAdjointEigenSolver<MatrixXd> gram(shapes.transpose() * shapes);
        directions_.setZero(size(), components_);
        for (int k = 0; k < components_; ++k) {
            directions_.col(k) =
                (shapes * gram.eigenvectors().col(shapes.cols() - 1 - k)).stableNormalized();
        }
        const MatrixXd left = shapes - directions_ * (directions_.transpose() * shapes);
        return left.squaredNorm() / static_cast<double>(left.size());
    }
    /// Before there is anything to go by.
    void reset() {
        mean_ = VectorXd::Zero(size());
        directions_ = MatrixXd::Zero(size(), components_);
    }
    Eigen::Index size() const { return 3 * Eigen::Index{vertex_count()}; }

  private:
    void append(CodeTable& table, const VectorXd& x) const {
        const std::vector<float> codes = to_floats(directions_.transpose() * (x - mean_));
        table.values.insert(table.values.end(), codes.begin(), codes.end());
    }
    static std::vector<float> to_floats(const VectorXd& values) {
        const Eigen::VectorXf rounded = values.cast<float>();
        return {rounded.begin(), rounded.end()};
    }
    static VectorXd vector_of(std::span<const float> codes) {
        return Eigen::Map<const Eigen::VectorXf>(codes.data(),
                                                 static_cast<Eigen::Index>(codes.size()))
            .cast<double>();
    }

    int components_;
    const TriangleMesh& reference_;
    VectorXd mean_;        // (3V)
    MatrixXd directions_;  // (3V,K)
};

/// One epoch, which is all that a closed form takes.
class PcaLearner final : public Learner {
  public:
    PcaLearner(Pca& model, const ShapeSet& shapes, std::span<const int> train)
        : model_(model), shapes_(shapes), train_(train.begin(), train.end()) {}

    std::vector<std::string> term_names() const override { return {"reconstruction"}; }
    void start() override {
        model_.reset();
        state_ = {};
    }
    void resume(const TrainingState& state) override { state_ = state; }
    const TrainingState& state() const override { return state_; }
    bool is_over() const override { return state_.epoch > 0; }
    CodeTable codes() override { return model_.encode(shapes_, train_); }
    EpochReport run_epoch() override {
        MatrixXd all(model_.size(), static_cast<Eigen::Index>(train_.size()));
        for (std::size_t m = 0; m < train_.size(); ++m) {
            const std::span<const float> x = shapes_.vertices(train_[m]);
            all.col(static_cast<Eigen::Index>(m)) =
                Eigen::Map<const Eigen::VectorXf>(x.data(), model_.size()).cast<double>();
        }
        const double error = model_.fit(std::move(all));
        if (!std::isfinite(error)) {
            throw NumericalError("principal directions of coordinates that are not finite");
        }
        state_.epoch = state_.step = 1;
        state_.total = error;
        return {state_, error, {error}, 0, 0, 1};
    }

  private:
    Pca& model_;
    const ShapeSet& shapes_;
    std::vector<int> train_;
    TrainingState state_;
};

std::unique_ptr<Learner> Pca::learner(const ShapeSet& shapes, std::span<const int> train) {
    return std::make_unique<PcaLearner>(*this, shapes, train);
}

void set_defaults(Config& config) {
    config.settings = PcaSettings{};
    config.train.epochs = 1;
    config.train.plateau_epochs = 0;
}

KindKeys keys(Config& config) {
    auto& own = config.own<PcaSettings>();
    return {"Principal components of the vertex positions.",
            {{"components", &own.components, kComponentCount,
              "directions, at most one less than training shapes"}},
            "",
            {},
            {}};
}

std::unique_ptr<LearnedModel> make(const Config& config, const ModelPlace& place) {
    const int most = std::max(1, place.shapes - 1);
    const int wanted = config.own<PcaSettings>().components;
    return std::make_unique<Pca>(place.use == ModelUse::training ? std::min(wanted, most) : wanted,
                                 place.reference);
}

}  // namespace

Kind pca() { return {"pca", always_positions, set_defaults, keys, make}; }

}  // namespace mscomp
