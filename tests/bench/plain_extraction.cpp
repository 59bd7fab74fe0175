// SPDX-License-Identifier: MIT
#include "plain_extraction.h"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <fstream>
#include <map>
#include <numbers>
#include <queue>
#include <sstream>
#include <stdexcept>
#include <utility>

namespace mscomp::plain {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

struct Mesh {
    std::vector<Vector3d> vertices;
    std::vector<std::array<int, 3>> faces;
};

Mesh read_obj(const std::string& path) {
    std::ifstream file(path);
    if (!file) throw std::runtime_error("cannot read " + path);
    Mesh mesh;
    std::string line;
    while (std::getline(file, line)) {
        std::istringstream words(line);
        std::string kind;
        words >> kind;
        if (kind == "v") {
            Vector3d p;
            words >> p.x() >> p.y() >> p.z();
            mesh.vertices.push_back(p);
        } else if (kind == "f") {
            std::array<int, 3> face{};
            for (int& corner : face) {
                std::string word;
                words >> word;
                corner = std::stoi(word) - 1;  // stops at a slash
            }
            mesh.faces.push_back(face);
        }
    }
    return mesh;
}

struct Neighbor {
    int vertex;
    double weight;
};
using Rings = std::vector<std::vector<Neighbor>>;

/// One-rings with the cotangent weights of their edges.
Rings rings_of(const Mesh& mesh) {
    std::vector<std::map<int, double>> weights(mesh.vertices.size());
    for (const auto& face : mesh.faces) {
        for (int k = 0; k < 3; ++k) {
            const int i = face[(k + 1) % 3], j = face[(k + 2) % 3];
            const Vector3d a = mesh.vertices[i] - mesh.vertices[face[k]];
            const Vector3d b = mesh.vertices[j] - mesh.vertices[face[k]];
            const double half_cotangent = 0.5 * a.dot(b) / a.cross(b).norm();
            weights[i][j] += half_cotangent;
            weights[j][i] += half_cotangent;
        }
    }
    Rings rings(mesh.vertices.size());
    for (std::size_t i = 0; i < rings.size(); ++i) {
        for (const auto& [j, weight] : weights[i]) rings[i].push_back({j, std::max(weight, 1e-3)});
    }
    return rings;
}

/// Every vertex's pseudo-edge: 0.3 mean edge lengths along the mean normal.
std::vector<Vector3d> pseudo_edges(const std::vector<Vector3d>& vertices, const Mesh& reference,
                                   const Rings& rings) {
    std::vector<Vector3d> result(vertices.size(), Vector3d::Zero());
    for (const auto& face : reference.faces) {
        const Vector3d &a = vertices[face[0]], &b = vertices[face[1]], &c = vertices[face[2]];
        const Vector3d normal = (b - a).cross(c - a).normalized();
        for (const int corner : face) result[corner] += normal;
    }
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        double length = 0;
        for (const auto& [j, weight] : rings[i]) length += (vertices[j] - vertices[i]).norm();
        result[i] = 0.3 * length / static_cast<double>(rings[i].size()) * result[i].normalized();
    }
    return result;
}

std::vector<Vector3d> aligned(const std::vector<Vector3d>& vertices, const Mesh& reference) {
    const auto count = static_cast<double>(vertices.size());
    Vector3d from = Vector3d::Zero(), to = Vector3d::Zero();
    for (const Vector3d& p : vertices) from += p;
    for (const Vector3d& p : reference.vertices) to += p;
    from /= count;
    to /= count;
    Matrix3d covariance = Matrix3d::Zero();
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        covariance += (reference.vertices[i] - to) * (vertices[i] - from).transpose();
    }
    Eigen::JacobiSVD<Matrix3d> svd(covariance, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3d u = svd.matrixU();
    if (u.determinant() * svd.matrixV().determinant() < 0) u.col(2) *= -1;
    const Matrix3d rotation = u * svd.matrixV().transpose();
    std::vector<Vector3d> result;
    for (const Vector3d& p : vertices) result.push_back(rotation * (p - from) + to);
    return result;
}

struct Feature {
    double angle;
    Vector3d axis;
    Vector3d rotation_vector;
    Matrix3d stretch;
};

Feature feature_of(const Matrix3d& gradient) {
    Eigen::JacobiSVD<Matrix3d> svd(gradient, Eigen::ComputeFullU | Eigen::ComputeFullV);
    Matrix3d u = svd.matrixU();
    if (u.determinant() * svd.matrixV().determinant() < 0) u.col(2) *= -1;
    const Matrix3d rotation = u * svd.matrixV().transpose();
    const Eigen::AngleAxisd turn(rotation);
    const Matrix3d stretch = rotation.transpose() * gradient;
    return {turn.angle(), turn.axis(), turn.angle() * turn.axis(),
            0.5 * (stretch + stretch.transpose())};
}

std::vector<Feature> features_of(const std::vector<Vector3d>& vertices, const Mesh& reference,
                                 const Rings& rings, const std::vector<Vector3d>& before) {
    const std::vector<Vector3d> after = pseudo_edges(vertices, reference, rings);
    std::vector<Feature> features;
    for (std::size_t i = 0; i < vertices.size(); ++i) {
        Matrix3d moment = before[i] * before[i].transpose();
        Matrix3d image = after[i] * before[i].transpose();
        for (const auto& [j, weight] : rings[i]) {
            const Vector3d e = reference.vertices[j] - reference.vertices[i];
            const Vector3d deformed = vertices[j] - vertices[i];
            moment += weight * e * e.transpose();
            image += weight * deformed * e.transpose();
        }
        features.push_back(feature_of(image * moment.inverse()));
    }
    return features;
}

void propagate(const Rings& rings, std::vector<Feature>& features) {
    std::vector<char> seen(features.size(), 0);
    for (std::size_t root = 0; root < features.size(); ++root) {
        if (seen[root]) continue;
        seen[root] = 1;
        std::queue<int> queue({static_cast<int>(root)});
        while (!queue.empty()) {
            const int i = queue.front();
            queue.pop();
            const Vector3d target = features[i].rotation_vector;
            for (const auto& [j, weight] : rings[i]) {
                if (seen[j]) continue;
                seen[j] = 1;
                queue.push(j);
                Feature& f = features[j];
                if (f.angle < 1e-6 && target.norm() > 0) f.axis = target.normalized();
                const double turns =
                    std::round((target.dot(f.axis) - f.angle) / (2 * std::numbers::pi));
                f.rotation_vector = (f.angle + 2 * std::numbers::pi * turns) * f.axis;
            }
        }
    }
}

double energy_of(const Rings& rings, const std::vector<Feature>& features) {
    double sum = 0;
    for (std::size_t i = 0; i < features.size(); ++i) {
        for (const auto& [j, weight] : rings[i]) {
            sum += (features[i].rotation_vector - features[j].rotation_vector).squaredNorm();
        }
    }
    return sum / 2;
}

void write(std::ofstream& file, const std::vector<Feature>& features) {
    for (const Feature& feature : features) {
        const Vector3d& r = feature.rotation_vector;
        const Matrix3d& s = feature.stretch;
        const double numbers[9] = {r.x(),   r.y(),   r.z(),   s(0, 0), s(0, 1),
                                   s(0, 2), s(1, 1), s(1, 2), s(2, 2)};
        for (const double number : numbers) {
            const auto rounded = static_cast<float>(number);
            file.write(reinterpret_cast<const char*>(&rounded), sizeof rounded);
        }
    }
}

}  // namespace

std::vector<double> extract(const std::vector<std::string>& paths, const std::string& output) {
    const Mesh reference = read_obj(paths.front());
    const Rings rings = rings_of(reference);
    const std::vector<Vector3d> before = pseudo_edges(reference.vertices, reference, rings);
    std::ofstream file(output, std::ios::binary);
    std::vector<double> energies;
    for (const std::string& path : paths) {
        const std::vector<Vector3d> vertices = aligned(read_obj(path).vertices, reference);
        std::vector<Feature> features = features_of(vertices, reference, rings, before);
        propagate(rings, features);
        energies.push_back(energy_of(rings, features));
        write(file, features);
    }
    if (!file.flush()) throw std::runtime_error("cannot write " + output);
    return energies;
}

}  // namespace mscomp::plain
