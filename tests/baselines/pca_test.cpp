// SPDX-License-Identifier: MIT
// The kind pca, as every method on positions: one file of src/baselines and one row of src/kinds.
#include <gtest/gtest.h>

#include <cmath>

#include "mscomp/base/error.h"
#include "mscomp/base/index.h"
#include "mscomp/base/random.h"
#include "mscomp/model/kind.h"
#include "shapes.h"

namespace mscomp {

Kind pca();  // what src/kinds knows of it

namespace {

/// Distances that nobody asks for.
class NoDistances final : public DistanceRows {
  public:
    explicit NoDistances(int vertices) : row_(at(vertices), 0.0) {}
    int vertex_count() const override { return static_cast<int>(row_.size()); }
    std::span<const double> row(int) override { return row_; }

  private:
    std::vector<double> row_;
};

/// Positions of shapes, whatever their features.
class Positions final : public ShapeSet {
  public:
    explicit Positions(std::vector<std::vector<float>> shapes) : shapes_(std::move(shapes)) {}
    int shape_count() const override { return static_cast<int>(shapes_.size()); }
    int vertex_count() const override { return static_cast<int>(shapes_.front().size() / 3); }
    std::span<const float> shape(int) const override { return {}; }
    std::span<const float> vertices(int index) const override { return shapes_[at(index)]; }
    void forget(int) const override {}

  private:
    std::vector<std::vector<float>> shapes_;
};

class Pca : public testing::Test {
  protected:
    /// The sphere plus two random displacements, `sizes` (n,2) of them.
    Positions displaced(const std::vector<std::array<float, 2>>& sizes) const {
        const CounterRandom random(5, 0);
        std::vector<std::vector<float>> shapes;
        for (const auto& size : sizes) {
            std::vector<float>& shape = shapes.emplace_back();
            for (std::size_t i = 0; i < 3 * mesh_.vertices.size(); ++i) {
                const double a = random.normal(i), b = random.normal(i + 10000);
                shape.push_back(static_cast<float>(mesh_.vertices[i / 3][i % 3] +
                                                   static_cast<double>(size[0]) * a +
                                                   static_cast<double>(size[1]) * b));
            }
        }
        return Positions(std::move(shapes));
    }
    std::unique_ptr<LearnedModel> fitted(const Positions& shapes, const std::vector<int>& train) {
        Config config;
        pca().set_defaults(config);
        const ModelPlace place{
            mesh_, distances_, {}, ModelUse::training, static_cast<int>(train.size()), {}};
        std::unique_ptr<LearnedModel> model = pca().make(config, place);
        const std::unique_ptr<Learner> learner = model->learner(shapes, train);
        learner->start();
        left_ = learner->run_epoch().total;
        EXPECT_TRUE(learner->is_over());
        return model;
    }
    static double largest_difference(std::span<const float> a, std::span<const float> b) {
        double largest = 0;
        for (std::size_t i = 0; i < a.size(); ++i) {
            const double difference = std::abs(static_cast<double>(a[i]) - b[i]);
            if (!(difference <= largest)) largest = difference;
        }
        return largest;
    }

    TriangleMesh mesh_ = shapes::icosphere(1);
    NoDistances distances_{mesh_.vertex_count()};
    double left_ = -1;
};

// Shapes in a plane: two directions say everything, of unseen shapes of that plane too, and no
// third one has any size.
TEST_F(Pca, OfShapesInAPlaneIsExact) {
    const Positions shapes = displaced({{0, 0}, {0.1F, 0}, {0, 0.2F}, {0.1F, -0.1F}, {0.3F, 0.4F}});
    const auto model = fitted(shapes, {0, 1, 2, 3});
    EXPECT_EQ(model->code_count(), 3);
    EXPECT_LT(left_, 1e-12);
    const CodeTable codes = model->encode(shapes, std::vector<int>{1, 4});
    for (const int m : {0, 1}) {
        EXPECT_LT(
            largest_difference(model->decode(codes.shape(m)), shapes.vertices(m == 0 ? 1 : 4)),
            1e-5);
        EXPECT_NEAR(codes.shape(m)[2], 0, 1e-4);
    }
}

// Directions are orthonormal, the one along which shapes vary most first.
TEST_F(Pca, DirectionsAreOrthonormalAndInOrder) {
    const Positions shapes = displaced({{0, 0}, {0.5F, 0.01F}, {-0.5F, 0.02F}, {0.1F, -0.04F}});
    const auto model = fitted(shapes, {0, 1, 2, 3});
    const std::vector<CodeColumn> columns = model->derivatives(std::vector<float>(3, 0.0F));
    for (std::size_t k = 0; k < 2; ++k) {
        for (std::size_t l = 0; l < 2; ++l) {
            double product = 0;
            for (std::size_t i = 0; i < columns[k].values.size(); ++i) {
                product += static_cast<double>(columns[k].values[i]) * columns[l].values[i];
            }
            EXPECT_NEAR(product, k == l ? 1 : 0, 1e-5);
        }
    }
    const CodeTable codes = model->encode(shapes, std::vector<int>{0, 1, 2, 3});
    double first = 0, second = 0;
    for (int m = 0; m < 4; ++m) {
        first += codes.shape(m)[0] * codes.shape(m)[0];
        second += codes.shape(m)[1] * codes.shape(m)[1];
    }
    EXPECT_GT(first, 10 * second);
}

// Positions have the unit of the mesh: strength is measured by the radius.
TEST_F(Pca, UnitIsTheRadiusOfTheReference) {
    for (Point& p : mesh_.vertices) {
        for (double& x : p) x *= 7;
    }
    const auto model = fitted(displaced({{0, 0}, {0.1F, 0}}), {0, 1});
    EXPECT_NEAR(model->unit(), 7, 1e-9);
    EXPECT_EQ(model->rows(), ShapeRows::positions);
}

TEST_F(Pca, RefusesWhatIsNotFinite) {
    Positions shapes = displaced({{0, 0}, {NAN, 0}});
    EXPECT_THROW(fitted(shapes, {0, 1}), NumericalError);
}

}  // namespace
}  // namespace mscomp
