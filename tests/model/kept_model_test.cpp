// SPDX-License-Identifier: MIT
#include "mscomp/model/kept_model.h"

#include <gtest/gtest.h>

#include <memory>

#include "dense.h"
#include "linear_model.h"
#include "mscomp/base/error.h"

namespace mscomp {
namespace {

using cases::LinearModel;
using cases::NoDistances;
using cases::normal_numbers;
using cases::table_of;
using Eigen::Index;
using Eigen::MatrixXd;

/// Component 1 is of no use, 4 goes along with 2, on two levels.
struct KeptCase {
    KeptCase() : changes(normal_numbers(27, 5, 1)), codes(normal_numbers(30, 5, 2)) {
        codes.col(1) *= 1e-3;
        codes.col(4) = -0.5 * codes.col(2) + 0.001 * codes.col(4);
        model = std::make_unique<LinearModel>(changes, std::vector<float>{}, 2);
        model->encoded = codes;
        NoDistances none(3);
        const double squares = (changes * codes.transpose()).squaredNorm();
        components = extract_components(*model, table_of(codes), {}, none, {}, 1e-2 * squares);
    }
    /// Of what acts.
    MatrixXd columns() const {
        MatrixXd result(27, 3);
        result << changes.col(0),
            changes.col(2) + components[2].others.at(0).ratio * changes.col(4), changes.col(3);
        return result;
    }

    MatrixXd changes, codes;
    std::unique_ptr<LinearModel> model;
    std::vector<Component> components;
};

// Σ z (C_k + those that move along), all others at the reference; derivatives are its columns.
TEST(KeptModel, DecodesWithKeptComponentsAlone) {
    KeptCase shapes;
    const KeptModel kept(*shapes.model, shapes.components);
    ASSERT_EQ(kept.code_count(), 3);
    const std::vector<float> codes{0.5F, -1, 2};
    const Eigen::VectorXd wanted = shapes.columns() * Eigen::Vector3d(0.5, -1, 2);
    const auto rows = kept.decode(codes);
    const auto derivatives = kept.derivatives(codes);
    for (Index i = 0; i < 27; ++i) {
        EXPECT_NEAR(rows[at(i)], wanted[i], 1e-5);
        for (Index k = 0; k < 3; ++k) {
            EXPECT_NEAR(derivatives[at(k)].values[at(i)], shapes.columns()(i, k), 1e-5);
        }
    }
}

// As near as these can be to what all components give.
TEST(KeptModel, CodesAreRefitted) {
    KeptCase shapes;
    const KeptModel kept(*shapes.model, shapes.components);
    const CodeTable codes = kept.refitted(table_of(shapes.codes));
    ASSERT_EQ(codes.shape_count(), 30);
    const MatrixXd fitted =
        cases::least_squares(shapes.columns(), shapes.changes * shapes.codes.transpose());
    for (int n = 0; n < 30; ++n) {
        for (int k = 0; k < 3; ++k) EXPECT_NEAR(codes.shape(n)[at(k)], fitted(k, n), 1e-4);
    }
}

// Levels, parents and ids are those of the kept ones; codes are counted anew.
TEST(KeptModel, CountsTheKeptOnes) {
    KeptCase shapes;
    const KeptModel kept(*shapes.model, shapes.components);
    ASSERT_EQ(kept.levels().size(), 2U);
    EXPECT_EQ(kept.levels()[0].codes(), 1);
    EXPECT_EQ(kept.levels()[1].codes(), 2);
    EXPECT_EQ(kept.parents(), (std::vector<int>{-1, 0, 0}));
    for (int k = 0; k < 3; ++k) EXPECT_EQ(kept.components()[at(k)].code, k);
    EXPECT_EQ(kept.components()[1].id, shapes.components[2].id);
    EXPECT_EQ(kept.places().size(), 3U);
}

TEST(KeptModel, RefusesWhereNoneIsKept) {
    KeptCase shapes;
    for (Component& c : shapes.components) c.kept = false;
    EXPECT_THROW(KeptModel(*shapes.model, shapes.components), UsageError);
}

}  // namespace
}  // namespace mscomp
