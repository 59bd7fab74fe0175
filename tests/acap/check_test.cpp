// SPDX-License-Identifier: MIT
// check: files, connectivity, copies and numbering. Each kind has a case that has it and one that
// nearly has it.
#include "mscomp/acap/check.h"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "check_cases.h"
#include "mscomp/acap/mesh/mesh_sequence.h"
#include "mscomp/base/error.h"
#include "mscomp/base/parallel.h"

namespace mscomp {
namespace {

using namespace cases;
using testing::HasSubstr;

TriangleMesh bent(const TriangleMesh& mesh, double amount) {
    return mapped(mesh, [=](const Vector3d& p) -> Vector3d {
        return p + amount * Vector3d(p.y() * p.y(), std::sin(2 * p.x()), p.x() * p.z());
    });
}

/// Everything a report says, for comparison.
std::string everything(const CheckReport& report) {
    std::string text = report.reference + std::to_string(report.usable) + report.stretch.file +
                       std::to_string(report.stretch.vertex);
    text.append(reinterpret_cast<const char*>(&report.stretch.largest), sizeof(double));
    text.append(reinterpret_cast<const char*>(&report.stretch.most_below), sizeof(double));
    for (const Finding& found : report.findings) {
        text += to_string(found.severity) + found.kind + std::to_string(found.count) +
                found.sentence + found.advice;
        for (const CheckPlace& place : found.places) text += place.text + place.file;
    }
    return text;
}

TEST(Check, FindsNothingInACleanClosedSet) {
    CheckedShapes shapes;
    for (int k = 0; k < 4; ++k) shapes.add(bent(bumpy_sphere(2), 0.05 * k));
    const CheckReport report = shapes.check();
    EXPECT_EQ(kinds_of(report), "");
    EXPECT_EQ(report.files, 4);
    EXPECT_EQ(report.usable, 4);
    EXPECT_EQ(report.reference, shapes.paths().front());
}

// Euler: V - E + F = 2 on a sphere; the unit sphere has a box of side 2 and scale 1.
TEST(Check, SummaryIsThatOfTheReference) {
    const CheckReport report = check_pair(shapes::icosphere(2), bumpy_sphere(2));
    EXPECT_EQ(report.vertices - report.edges + report.faces, 2);
    EXPECT_EQ(report.components, 1);
    EXPECT_EQ(report.boundary_loops, 0);
    EXPECT_NEAR(report.unit_ball_scale, 1, 1e-6);
    EXPECT_NEAR(report.highest[2] - report.lowest[2], 2, 0.1);
}

TEST(Check, GoesOnAfterBadFilesAndSortsThemByKind) {
    const TriangleMesh good = shapes::icosphere(1);
    TriangleMesh turned = good;
    std::swap(turned.faces[3][0], turned.faces[3][1]);
    CheckedShapes shapes;
    shapes.add_as("a.obj", good);
    shapes.add_text("b.obj", "v 0 0 0\nv 1 0 nan\n");
    shapes.add_as("c.obj", shapes::icosphere(2));
    shapes.add_as("d.obj", turned);
    shapes.add_missing("e.obj");
    shapes.add_as("f.obj", bent(good, 0.1));
    const CheckReport report = shapes.check();
    EXPECT_EQ(report.usable, 2);
    EXPECT_EQ(report.count(Severity::error), 4);
    EXPECT_THAT(finding(report, "malformed_file").places.at(0).text, HasSubstr("b.obj:2"));
    EXPECT_EQ(finding(report, "malformed_file").places.at(0).line, 2);
    EXPECT_EQ(finding(report, "other_vertex_count").places.at(0).file, shapes.path("c.obj"));
    EXPECT_EQ(finding(report, "other_faces").places.at(0).file, shapes.path("d.obj"));
    EXPECT_EQ(finding(report, "unreadable_file").places.at(0).file, shapes.path("e.obj"));
}

TEST(Check, TakesTheSameFacesInAnotherOrder) {
    TriangleMesh other = bent(shapes::icosphere(1), 0.1);
    std::reverse(other.faces.begin(), other.faces.end());
    std::rotate(other.faces[0].begin(), other.faces[0].begin() + 1, other.faces[0].end());
    const CheckReport report = check_pair(shapes::icosphere(1), other);
    EXPECT_EQ(report.count(Severity::error), 0);
    EXPECT_EQ(count_of(report, "permuted_vertices"), 0);
}

TEST(Check, UsesTheFirstReadableFileIfTheReferenceIsBroken) {
    CheckedShapes shapes;
    shapes.add_text("a.obj", "v 0 0\n");
    shapes.add_text("b.obj", "f 1 2 3\n");
    shapes.add_as("c.obj", bumpy_sphere(1));
    shapes.add_as("d.obj", bent(bumpy_sphere(1), 0.1));
    const CheckReport report = shapes.check();
    EXPECT_EQ(report.reference, shapes.path("c.obj"));
    EXPECT_EQ(count_of(report, "unreadable_reference"), 1);
    EXPECT_EQ(count_of(report, "malformed_file"), 2);
    EXPECT_EQ(report.usable, 2);
}

TEST(Check, SaysSoIfNothingCanBeRead) {
    CheckedShapes shapes;
    shapes.add_text("a.obj", "v 0 0\n");
    shapes.add_missing("b.obj");
    const CheckReport report = shapes.check();
    EXPECT_EQ(report.reference, "");
    EXPECT_EQ(report.usable, 0);
    EXPECT_EQ(count_of(report, "malformed_file"), 1);
    EXPECT_EQ(count_of(report, "unreadable_file"), 1);
}

TEST(Check, SuspectsTheReferenceIfMostOthersAgree) {
    CheckedShapes shapes;
    shapes.add(shapes::icosphere(2));
    for (int k = 0; k < 3; ++k) shapes.add(bent(shapes::icosphere(1), 0.1 * k));
    EXPECT_THAT(finding(shapes.check(), "other_vertex_count").advice, HasSubstr("odd one out"));
    CheckOptions options;
    options.reference_index = 1;
    EXPECT_EQ(count_of(shapes.check(options), "other_vertex_count"), 1);
}

TEST(Check, TakesAReferenceFromOutsideTheSet) {
    CheckedShapes shapes, outside;
    for (int k = 1; k < 3; ++k) shapes.add(bent(bumpy_sphere(1), 0.1 * k));
    outside.add(bumpy_sphere(1));
    CheckOptions options;
    options.reference_file = outside.paths().front();
    EXPECT_EQ(shapes.check(options).reference, outside.paths().front());
    EXPECT_EQ(shapes.check(options).files, 2);
    options = {2, ""};
    EXPECT_THROW(shapes.check(options), UsageError);
}

TEST(Check, NamesAReferenceThatIsTooSmallForFloat) {
    const TriangleMesh tiny = mapped(bumpy_sphere(1), [](const Vector3d& p) { return 1e-40 * p; });
    const CheckReport report = check_pair(tiny, tiny);
    EXPECT_EQ(finding(report, "reference_too_small").severity, Severity::error);
    EXPECT_EQ(count_of(report, "reference_too_small"), 1);
    EXPECT_EQ(count_of(report, "reference_without_area"), 0);
}

TEST(Check, NeedsAReferenceWithArea) {
    TriangleMesh flat = shapes::grid(3, 3);
    for (Point& p : flat.vertices) p = {0, 0, 0};
    EXPECT_EQ(count_of(check_pair(flat, shapes::grid(3, 3)), "reference_without_area"), 1);
}

/// A grid with everything that can be wrong with faces.
TriangleMesh odd_grid() {
    TriangleMesh mesh = shapes::grid(4, 4);
    const int fin = mesh.vertex_count();
    mesh.vertices.push_back({0.5, 0, 1});   // on the edge 0 - 1, which then has
    mesh.vertices.push_back({0.5, 0, -1});  // three faces
    mesh.vertices.push_back({9, 9, 9});     // in no face
    mesh.vertices.push_back({3, 3, 1});     // touches at vertex 15
    mesh.vertices.push_back({3, 4, 1});
    mesh.faces.push_back({0, 1, fin});
    mesh.faces.push_back({1, 0, fin + 1});
    mesh.faces.push_back({15, fin + 3, fin + 4});
    mesh.faces.push_back(mesh.faces[6]);
    mesh.faces.push_back({2, 2, 3});
    return mesh;
}

TEST(Check, CountsAndPlacesOfOddConnectivityAgreeWithTheReport) {
    const TriangleMesh mesh = odd_grid();
    const ConnectivityReport expected =
        analyze_connectivity(mesh.vertex_count(), mesh.faces).report;
    const CheckReport report = check_pair(mesh, bent(mesh, 0.01));
    EXPECT_EQ(count_of(report, "non_manifold_edges") + count_of(report, "misoriented_edges"),
              expected.non_manifold_edges);
    EXPECT_EQ(count_of(report, "non_manifold_vertices"), expected.non_manifold_vertices);
    EXPECT_EQ(count_of(report, "duplicate_faces"), 1);
    EXPECT_EQ(count_of(report, "degenerate_faces"), 1);
    EXPECT_EQ(count_of(report, "isolated_vertices"), 1);
    EXPECT_EQ(count_of(report, "boundary"), expected.boundary_loops);
    EXPECT_EQ(count_of(report, "several_components"), 0);
    const CheckPlace edge = finding(report, "non_manifold_edges").places.at(0);
    EXPECT_EQ(edge.vertex, 1);
    EXPECT_EQ(edge.other_vertex, 2);
    EXPECT_EQ(finding(report, "duplicate_faces").places.at(0).face, mesh.face_count() - 1);
    EXPECT_THAT(finding(report, "duplicate_faces").places.at(0).text, HasSubstr("as face 7"));
    EXPECT_EQ(finding(report, "degenerate_faces").places.at(0).face, mesh.face_count());
    EXPECT_EQ(finding(report, "isolated_vertices").places.at(0).vertex, 19);
}

TEST(Check, NeighboursOfOppositeOrientationAreNotCrowded) {
    TriangleMesh mesh = shapes::icosphere(1);
    std::swap(mesh.faces[0][0], mesh.faces[0][1]);
    const CheckReport report = check_pair(mesh, bent(mesh, 0.1));
    EXPECT_EQ(count_of(report, "misoriented_edges"), 3);
    EXPECT_EQ(count_of(report, "non_manifold_edges"), 0);
}

TEST(Check, ListsThePiecesWithTheirSizes) {
    TriangleMesh mesh = shapes::icosphere(0);
    const TriangleMesh second = shapes::icosphere(1);
    for (Point p : second.vertices) mesh.vertices.push_back({p[0] + 5, p[1], p[2]});
    for (const Face& f : second.faces) mesh.faces.push_back({f[0] + 12, f[1] + 12, f[2] + 12});
    const CheckReport report = check_pair(mesh, bent(mesh, 0.01));
    const Finding pieces = finding(report, "several_components");
    ASSERT_EQ(pieces.places.size(), 2u);
    EXPECT_EQ(pieces.places[0].count, 12);
    EXPECT_EQ(pieces.places[1].count, 42);
    EXPECT_EQ(pieces.places[1].vertex, 13);
    EXPECT_EQ(report.components, 2);
}

// Two quads make four triangles; the third of them belongs to the second face of the file.
TEST(Check, NumbersFacesAsTheFileHasThem) {
    CheckedShapes shapes;
    const std::string faces = "f 1 2 3 4\nf 2 5 6 3\n";
    shapes.add_text("a.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 2 0 0\nv 2 1 0\n" + faces);
    shapes.add_text("b.obj", "v 0 0 0\nv 1 0 0\nv 1 1 0\nv 0 1 0\nv 1 0 0\nv 1 2 0\n" + faces);
    const CheckReport report = shapes.check();
    EXPECT_EQ(report.faces, 2);
    EXPECT_EQ(finding(report, "zero_area_faces").places.at(0).face, 2);
}

TEST(Check, FindsExactRepetitions) {
    CheckedShapes shapes;
    for (const double amount : {0.0, 0.1, 0.2, 0.1, 0.1, 0.0, 0.1000001}) {
        shapes.add(bent(bumpy_sphere(1), amount));
    }
    const CheckReport report = shapes.check();
    const Finding repeated = finding(report, "repeated_frames");
    ASSERT_EQ(repeated.count, 3);
    EXPECT_EQ(repeated.places[0].text, "frame_3.obj = frame_1.obj");
    EXPECT_EQ(repeated.places[2].text, "frame_5.obj = frame_0.obj");
    EXPECT_EQ(count_of(report, "same_as_reference"), 1);
    EXPECT_EQ(count_of(report, "rigid_copies"), 1);  // the last one, within rounding
}

TEST(Check, FindsCopiesThatWereMovedAsAWhole) {
    const TriangleMesh shape = bent(bumpy_sphere(3), 0.2);
    const TriangleMesh turned = mapped(shape, [](const Vector3d& p) -> Vector3d {
        return rotation_about({1, 2, 3}, 2.5) * p + Vector3d(4, -5, 6);
    });
    TriangleMesh nearly = turned;
    nearly.vertices[77][0] += 1e-3;
    CheckedShapes shapes;
    for (const TriangleMesh& mesh : {bumpy_sphere(3), shape, nearly, turned}) shapes.add(mesh);
    const Finding copies = finding(shapes.check(), "rigid_copies");
    ASSERT_EQ(copies.count, 1);
    EXPECT_EQ(copies.places[0].text, "frame_3.obj = frame_1.obj");
}

CheckReport check_names(const std::vector<std::string>& names) {
    CheckedShapes shapes;
    for (std::size_t k = 0; k < names.size(); ++k) {
        shapes.add_as(names[k] + ".obj", bent(bumpy_sphere(0), 0.01 * static_cast<double>(k)));
    }
    return shapes.check();
}

TEST(Check, FindsGapsInTheNumbering) {
    const CheckReport report = check_names({"f_0005", "f_0006", "f_0008", "f_0009", "f_0012"});
    const Finding gaps = finding(report, "missing_numbers");
    ASSERT_EQ(gaps.count, 3);
    EXPECT_EQ(gaps.places.at(0).text, "f_0007 between f_0006.obj and f_0008.obj");
    EXPECT_EQ(gaps.places.at(1).text, "f_0010 and 1 more between f_0009.obj and f_0012.obj");
    EXPECT_EQ(gaps.severity, Severity::note);
}

TEST(Check, AStepIsNoGap) {
    EXPECT_EQ(kinds_of(check_names({"f_00", "f_03", "f_06", "f_09"})), "");
    EXPECT_EQ(kinds_of(check_names({"a_1", "a_2", "b_7_x", "b_8_x", "rest"})), "");
    EXPECT_EQ(count_of(check_names({"f_0", "f_2", "f_4", "f_8"}), "missing_numbers"), 1);
}

TEST(Check, FindsNumbersOfMixedWidthAndTwice) {
    const CheckReport report = check_names({"f_7", "f_07", "f_08"});
    EXPECT_EQ(count_of(report, "mixed_padding"), 1);
    EXPECT_EQ(count_of(report, "same_number_twice"), 1);
    EXPECT_EQ(kinds_of(check_names({"f_08", "f_09", "f_10"})), "");
    EXPECT_EQ(count_of(check_names({"f_98", "f_99", "f_100"}), "mixed_padding"), 0);
}

TEST(Check, SaysWhereOrdersDiffer) {
    EXPECT_EQ(kinds_of(check_names({"f_8", "f_9", "f_10"})), "order_not_plain ");
    EXPECT_EQ(kinds_of(check_names({"f_10", "f_9", "f_8"})), "order_not_natural ");
    EXPECT_EQ(kinds_of(check_names({"f_1", "f_2", "f_3"})), "");
}

TEST(Check, OneShapeIsNotASet) {
    CheckedShapes shapes;
    shapes.add(bumpy_sphere(1));
    EXPECT_EQ(kinds_of(shapes.check()), "single_shape ");
}

TEST(Check, CountsGoOnWherePlacesEnd) {
    CheckedShapes shapes;
    for (int k = 0; k < 103; ++k) shapes.add(bumpy_sphere(0));
    const Finding repeated = finding(shapes.check(), "repeated_frames");
    EXPECT_EQ(repeated.count, 102);
    EXPECT_EQ(repeated.places.size(), kPlacesKept);
}

TEST(Check, IsTheSameForAnyNumberOfThreads) {
    CheckedShapes shapes;
    for (int k = 0; k < 20; ++k) shapes.add(bent(bumpy_sphere(2), 0.03 * (k % 17)));
    shapes.add_text("bad.obj", "v 1,5 0 0\n");
    shapes.add(shifted(bumpy_sphere(2), 1));
    std::vector<std::string> reports;
    for (const int threads : {1, 2, 7}) {
        set_thread_count(threads);
        reports.push_back(everything(shapes.check()));
    }
    set_thread_count(0);
    EXPECT_EQ(reports[1], reports[0]);
    EXPECT_EQ(reports[2], reports[0]);
}

TEST(Check, ProgressReachesTheEndAndMayStopIt) {
    CheckedShapes shapes;
    for (int k = 0; k < 5; ++k) shapes.add(bent(bumpy_sphere(1), 0.1 * k));
    int last = 0;
    check_meshes(shapes.paths(), {}, [&](int done, int) { last = done; });
    EXPECT_EQ(last, 5);
    const auto stop = [](int, int) { throw Interrupted(2, "stopped"); };
    EXPECT_THROW(check_meshes(shapes.paths(), {}, stop), Interrupted);
}

}  // namespace
}  // namespace mscomp
