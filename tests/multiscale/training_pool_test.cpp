// SPDX-License-Identifier: MIT
#include "multiscale/training_pool.h"

#include <gtest/gtest.h>

#include <set>

#include "ball_cases.h"

namespace mscomp {
namespace {

class TrainingPoolTest : public testing::Test {
  protected:
    static std::vector<float> random_features(int vertices) {
        const Eigen::MatrixXd random = 0.1 * cases::random_matrix(9 * vertices, kShapes, 4);
        std::vector<float> features;
        for (Eigen::Index i = 0; i < random.size(); ++i) {
            features.push_back(kReferenceFeature[at(i) % kFeatureDim] +
                               static_cast<float>(random.data()[i]));
        }
        return features;
    }
    TrainingPool pool(int fill_up_to, const Mirror* mirror = nullptr) {
        return {memory_, train_, mirror, sphere_.distances, sphere_.scale, {fill_up_to, 3, 0.3}};
    }
    static std::set<std::vector<float>> shapes_of(const MetricRows& rows) {
        std::set<std::vector<float>> shapes;
        for (int m = 0; m < rows.shape_count(); ++m) {
            std::vector<float> row;
            for (std::size_t i = 0; i < at(rows.vertex_count()) * 9; ++i) {
                row.push_back(rows.value(i, m));
            }
            shapes.insert(std::move(row));
        }
        return shapes;
    }

    static constexpr int kShapes = 6;
    cases::Sphere sphere_;
    std::vector<float> features_ = random_features(sphere_.vertices());
    MemoryFeatures memory_{features_, sphere_.vertices()};
    std::vector<int> train_{0, 2, 5};
};

TEST_F(TrainingPoolTest, HasTheTrainingShapesMapped) {
    TrainingPool all = pool(0);
    const MetricRows& rows = all.rows(0);
    ASSERT_EQ(rows.shape_count(), 3);
    std::vector<float> row(at(sphere_.vertices()) * 9);
    for (int m = 0; m < 3; ++m) {
        std::ranges::copy(memory_.shape(train_[at(m)]), row.begin());
        sphere_.scale.scale(row);
        for (std::size_t i = 0; i < row.size(); ++i) ASSERT_EQ(rows.value(i, m), row[i]);
    }
    // And back.
    sphere_.scale.unscale(row);
    for (std::size_t i = 0; i < row.size(); ++i) {
        ASSERT_NEAR(row[i], memory_.shape(5)[i], 1e-6);
    }
}

// A mirror doubles them: behind the shapes come their images.
TEST_F(TrainingPoolTest, HasMirrorImages) {
    const std::optional<Mirror> mirror = mirror_of(sphere_.mesh);
    ASSERT_TRUE(mirror);
    TrainingPool all = pool(0, &*mirror);
    ASSERT_EQ(all.shape_count(), 6);
    const MirroredFeatures mirrored(memory_, *mirror);
    std::vector<float> row(at(sphere_.vertices()) * 9);
    std::ranges::copy(mirrored.shape(kShapes + 2), row.begin());
    sphere_.scale.scale(row);
    const MetricRows& rows = all.rows(0);
    for (std::size_t i = 0; i < row.size(); ++i) ASSERT_EQ(rows.value(i, 4), row[i]);
}

// Mixed shapes: as many as are missing, four of them new each round, whatever was asked before.
TEST_F(TrainingPoolTest, FillsUpAsAFunctionOfTheRound) {
    TrainingPool all = pool(13), other = pool(13);
    ASSERT_EQ(all.shape_count(), 13);
    const auto first = shapes_of(all.rows(0)), second = shapes_of(all.rows(1)),
               later = shapes_of(all.rows(7));
    EXPECT_EQ(first.size(), 13U);
    int kept = 0;
    for (const auto& shape : second) kept += first.contains(shape) ? 1 : 0;
    EXPECT_EQ(kept, 9);
    EXPECT_EQ(shapes_of(other.rows(7)), later);
    EXPECT_EQ(shapes_of(all.rows(1)), second);
    EXPECT_EQ(shapes_of(all.rows(0)), first);
}

}  // namespace
}  // namespace mscomp
