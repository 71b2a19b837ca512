#include "server/core/mesh/build/flattening.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <map>
#include <numbers>
#include <numeric>
#include <string>
#include <utility>
#include <vector>

#include <Eigen/Eigenvalues>
#include <Eigen/Geometry>
#include <Eigen/SparseCholesky>
#include <Eigen/SparseCore>

#include "server/base/elementary.h"

namespace kerf::mesh {
namespace {

using Complex = std::complex<double>;
using Triplet = Eigen::Triplet<double>;

// Least weight of Tutte's embedding, which needs positive ones; cotangents may be negative.
constexpr double kLeastWeight = 0.05;
// A surface faces no side if the sum of its area vectors is shorter than this fraction of its area.  -
constexpr double kFacesNowhere = 0.05;
constexpr double kGap = 0.1;  // -; gap between two components, over the larger side of the second

Error refuse(std::string reason, std::string message) {
  return invalid_argument(std::move(reason), std::move(message), "surface");
}

// One connected component of the surface, with its own vertex numbers.
struct Component {
  std::vector<int> vertices;                  // vertex of the whole surface, by number in the component
  std::vector<std::array<int, 3>> triangles;  // corners, numbers in the component
  std::vector<Eigen::Vector3d> at;            // m
  std::vector<std::vector<int>> loops;        // borders, each a list of vertices with the material on the left
};

std::vector<Component> split_components(const Eigen::Matrix3Xd& surface, const Eigen::Matrix3Xi& triangles) {
  std::vector<int> parent(static_cast<std::size_t>(surface.cols()));
  std::iota(parent.begin(), parent.end(), 0);
  const auto root = [&](int v) {
    while (parent[v] != v) v = parent[v] = parent[parent[v]];
    return v;
  };
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    for (int k = 1; k < 3; ++k) {
      const auto [low, high] = std::minmax({root(triangles(0, t)), root(triangles(k, t))});
      parent[high] = low;
    }
  }
  std::vector<Component> components;
  std::vector<int> component_of(parent.size(), -1), number(parent.size(), -1);
  for (int v = 0; v < static_cast<int>(parent.size()); ++v) {
    int& component = component_of[root(v)];
    if (component < 0) {
      component = static_cast<int>(components.size());
      components.emplace_back();
    }
    component_of[v] = component;
    number[v] = static_cast<int>(components[component].vertices.size());
    components[component].vertices.push_back(v);
    components[component].at.push_back(surface.col(v));
  }
  for (Eigen::Index t = 0; t < triangles.cols(); ++t) {
    const std::array<int, 3> corners{number[triangles(0, t)], number[triangles(1, t)], number[triangles(2, t)]};
    components[component_of[triangles(0, t)]].triangles.push_back(corners);
  }
  return components;
}

// Finds the borders of a component. Refuses surfaces that are closed, not orientable, not manifold, or that have
// handles.
Status find_borders(Component& part, const ElementNames& names) {
  std::map<std::pair<int, int>, int> sides;  // directed edge -> triangle
  const auto name = [&](int v) { return names.vertex(part.vertices[v]); };
  for (std::size_t t = 0; t < part.triangles.size(); ++t) {
    for (std::size_t k = 0; k < 3; ++k) {
      const std::pair<int, int> side{part.triangles[t][k], part.triangles[t][(k + 1) % 3]};
      if (!sides.emplace(side, static_cast<int>(t)).second) {
        return refuse("MESH_INCONSISTENT_ORIENTATION",
                      "two triangles run along " + names.edge(part.vertices[side.first], part.vertices[side.second]) +
                          " in the same direction: they have opposite orientations, or more than two meet there");
      }
    }
  }
  std::vector<int> next(part.vertices.size(), -1);
  std::size_t num_borders = 0;
  for (const auto& [side, triangle] : sides) {
    if (sides.contains({side.second, side.first})) continue;
    ++num_borders;
    if (next[side.first] >= 0) {
      return refuse("MESH_NON_MANIFOLD_VERTEX",
                    "triangles meet at " + name(side.first) + " without a common edge; duplicate the vertex");
    }
    next[side.first] = side.second;
  }
  for (std::size_t first = 0; first < next.size(); ++first) {
    if (next[first] < 0) continue;
    part.loops.emplace_back();
    for (int v = static_cast<int>(first); next[v] >= 0; v = std::exchange(next[v], -1)) part.loops.back().push_back(v);
  }
  const std::size_t num_edges = (sides.size() + num_borders) / 2;
  const auto euler =
      static_cast<std::int64_t>(part.vertices.size() + part.triangles.size()) - static_cast<std::int64_t>(num_edges);
  const std::string where = "the surface with " + name(0);
  if (part.loops.empty()) {
    return refuse("MESH_NOT_FLATTENABLE",
                  where + " is closed; cut it open along seams, or give texture coordinates with seams");
  }
  if (euler + static_cast<std::int64_t>(part.loops.size()) != 2) {
    return refuse("MESH_NOT_FLATTENABLE",
                  where +
                      " has handles, or fans that meet at a vertex; cut it open along seams, or give texture "
                      "coordinates with seams");
  }
  return Nothing{};
}

double total_area(const Component& part) {
  double area = 0.0;
  for (const auto& [a, b, c] : part.triangles) {
    area += 0.5 * (part.at[b] - part.at[a]).cross(part.at[c] - part.at[a]).norm();
  }
  return area;
}

// Returns half the cotangent of the angle at each corner of a triangle.
std::array<double, 3> half_cotangents(const Component& part, const std::array<int, 3>& triangle) {
  std::array<double, 3> half{};
  for (std::size_t k = 0; k < 3; ++k) {
    const Eigen::Vector3d u = part.at[triangle[(k + 1) % 3]] - part.at[triangle[k]];
    const Eigen::Vector3d v = part.at[triangle[(k + 2) % 3]] - part.at[triangle[k]];
    half[k] = 0.5 * u.dot(v) / u.cross(v).norm();
  }
  return half;
}

// Solves the rows of A x = 0 that belong to unknowns without a given value. `entries`: A, size x size, symmetric,
// positive definite in these unknowns. `given`: value by unknown. Returns all of x, or an empty vector if the
// factorisation fails.
Eigen::VectorXd solve_for_free(Eigen::Index size, const std::vector<Triplet>& entries,
                               const std::map<Eigen::Index, double>& given) {
  std::vector<Eigen::Index> place(static_cast<std::size_t>(size), -1);
  Eigen::Index num_free = 0;
  for (Eigen::Index i = 0; i < size; ++i) {
    if (!given.contains(i)) place[i] = num_free++;
  }
  std::vector<Triplet> inner;
  Eigen::VectorXd rhs = Eigen::VectorXd::Zero(num_free);
  for (const Triplet& entry : entries) {
    const Eigen::Index row = place[entry.row()];
    const Eigen::Index column = place[entry.col()];
    if (row < 0) continue;
    if (column < 0) {
      rhs[row] -= entry.value() * given.at(entry.col());
    } else {
      inner.emplace_back(static_cast<int>(row), static_cast<int>(column), entry.value());
    }
  }
  Eigen::SparseMatrix<double> matrix(num_free, num_free);
  matrix.setFromTriplets(inner.begin(), inner.end());
  const Eigen::SimplicialLDLT<Eigen::SparseMatrix<double>> factor(matrix);
  if (factor.info() != Eigen::Success) return {};
  const Eigen::VectorXd solved = factor.solve(rhs);
  Eigen::VectorXd x(size);
  for (Eigen::Index i = 0; i < size; ++i) x[i] = place[i] < 0 ? given.at(i) : solved[place[i]];
  return x;
}

void add_edge(std::vector<Triplet>& entries, int i, int j, double weight) {
  entries.emplace_back(i, i, weight);
  entries.emplace_back(j, j, weight);
  entries.emplace_back(i, j, -weight);
  entries.emplace_back(j, i, -weight);
}

// Returns two vertices of the borders that lie far from each other.
std::pair<int, int> far_pair(const Component& part) {
  const auto farthest = [&](int from) {
    int found = from;
    for (const std::vector<int>& loop : part.loops) {
      for (const int v : loop) {
        if ((part.at[v] - part.at[from]).squaredNorm() > (part.at[found] - part.at[from]).squaredNorm()) found = v;
      }
    }
    return found;
  };
  const int first = farthest(part.loops.front().front());
  return {first, farthest(first)};
}

// Maps by least conformal energy: the Dirichlet energy of both coordinates minus the area of the map. The area is a sum
// over border edges.
std::vector<Complex> map_conformally(const Component& part) {
  const auto size = static_cast<int>(part.vertices.size());
  std::vector<Triplet> entries;
  for (const std::array<int, 3>& triangle : part.triangles) {
    const std::array<double, 3> half = half_cotangents(part, triangle);
    for (std::size_t k = 0; k < 3; ++k) {
      const int i = triangle[(k + 1) % 3], j = triangle[(k + 2) % 3];
      add_edge(entries, i, j, half[k]);
      add_edge(entries, size + i, size + j, half[k]);
    }
  }
  for (const std::vector<int>& loop : part.loops) {
    for (std::size_t k = 0; k < loop.size(); ++k) {
      const int i = loop[k], j = loop[(k + 1) % loop.size()];
      entries.emplace_back(i, size + j, -0.5);
      entries.emplace_back(size + j, i, -0.5);
      entries.emplace_back(j, size + i, 0.5);
      entries.emplace_back(size + i, j, 0.5);
    }
  }
  const auto [p, q] = far_pair(part);
  const double distance = (part.at[p] - part.at[q]).norm();
  const Eigen::VectorXd x =
      solve_for_free(2 * Eigen::Index{size}, entries, {{p, 0.0}, {size + p, 0.0}, {q, distance}, {size + q, 0.0}});
  std::vector<Complex> mapped;
  for (int v = 0; x.size() > 0 && v < size; ++v) mapped.emplace_back(x[v], x[size + v]);
  return mapped;
}

// Maps by Tutte's embedding. Each inner border (a hole) is filled with one extra vertex, joined to all its vertices.
std::vector<Complex> map_into_circle(const Component& part) {
  const auto length = [&](const std::vector<int>& loop) {
    double sum = 0.0;
    for (std::size_t k = 0; k < loop.size(); ++k)
      sum += (part.at[loop[k]] - part.at[loop[(k + 1) % loop.size()]]).norm();
    return sum;
  };
  const auto outer = std::max_element(part.loops.begin(), part.loops.end(),
                                      [&](const auto& a, const auto& b) { return length(a) < length(b); });
  std::map<std::pair<int, int>, double> weights;
  for (const std::array<int, 3>& triangle : part.triangles) {
    const std::array<double, 3> half = half_cotangents(part, triangle);
    for (std::size_t k = 0; k < 3; ++k) {
      weights[std::minmax(triangle[(k + 1) % 3], triangle[(k + 2) % 3])] += half[k];
    }
  }
  std::vector<Triplet> entries;
  for (const auto& [edge, weight] : weights) add_edge(entries, edge.first, edge.second, std::max(weight, kLeastWeight));
  auto size = static_cast<int>(part.vertices.size());
  for (auto loop = part.loops.begin(); loop != part.loops.end(); ++loop) {
    if (loop == outer) continue;
    for (const int v : *loop) add_edge(entries, size, v, 1.0);
    ++size;
  }
  std::map<Eigen::Index, double> x_given, y_given;
  const double whole = length(*outer);
  double along = 0.0;
  for (std::size_t k = 0; k < outer->size(); ++k) {
    const double angle = 2.0 * std::numbers::pi * along / whole;
    x_given[(*outer)[k]] = cosine(angle);
    y_given[(*outer)[k]] = sine(angle);
    along += (part.at[(*outer)[k]] - part.at[(*outer)[(k + 1) % outer->size()]]).norm();
  }
  const Eigen::VectorXd x = solve_for_free(size, entries, x_given);
  const Eigen::VectorXd y = solve_for_free(size, entries, y_given);
  std::vector<Complex> mapped;
  for (std::size_t v = 0; x.size() > 0 && y.size() > 0 && v < part.vertices.size(); ++v) {
    mapped.emplace_back(x[static_cast<Eigen::Index>(v)], y[static_cast<Eigen::Index>(v)]);
  }
  return mapped;
}

// Projects the surface along its mean normal. A surface that faces no side is projected along the direction in which it
// extends least.
std::vector<Complex> project(const Component& part) {
  Eigen::Vector3d normal = Eigen::Vector3d::Zero();
  for (const auto& [a, b, c] : part.triangles) {
    normal += 0.5 * (part.at[b] - part.at[a]).cross(part.at[c] - part.at[a]);
  }
  if (normal.norm() < kFacesNowhere * total_area(part)) {
    Eigen::Vector3d middle = Eigen::Vector3d::Zero();
    for (const Eigen::Vector3d& at : part.at) middle += at / static_cast<double>(part.at.size());
    Eigen::Matrix3d spread = Eigen::Matrix3d::Zero();
    for (const Eigen::Vector3d& at : part.at) spread += (at - middle) * (at - middle).transpose();
    normal = Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d>(spread).eigenvectors().col(0);
  }
  normal.normalize();
  const Eigen::Vector3d axis = std::abs(normal.x()) < 0.9 ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitY();
  const Eigen::Vector3d u = (axis - normal.dot(axis) * normal).normalized();
  const Eigen::Vector3d v = normal.cross(u);
  std::vector<Complex> projected;
  for (const Eigen::Vector3d& at : part.at) projected.emplace_back(u.dot(at), v.dot(at));
  return projected;
}

Complex mean(const std::vector<Complex>& values) {
  return std::accumulate(values.begin(), values.end(), Complex(0.0, 0.0)) / static_cast<double>(values.size());
}

// Scales the map to the area of the surface. Then rotates and moves it to fit the projection of the surface best.
Status align(const Component& part, const ElementNames& names, std::vector<Complex>& mapped) {
  double area = 0.0;
  for (const auto& [a, b, c] : part.triangles) {
    area += 0.5 * (std::conj(mapped[b] - mapped[a]) * (mapped[c] - mapped[a])).imag();
  }
  const double wanted = total_area(part);
  if (!(area > 0.0) || !(wanted > 0.0) || !std::isfinite(area)) {
    return refuse("MESH_NOT_FLATTENABLE", "the surface with " + names.vertex(part.vertices[0]) + " has no area");
  }
  const std::vector<Complex> target = project(part);
  const Complex from = mean(mapped);
  const Complex to = mean(target);
  Complex turn(0.0, 0.0);
  for (std::size_t v = 0; v < mapped.size(); ++v) turn += std::conj(mapped[v] - from) * (target[v] - to);
  const Complex unit = std::abs(turn) > 0.0 ? turn / std::abs(turn) : Complex(1.0, 0.0);
  for (Complex& z : mapped) z = to + std::sqrt(wanted / area) * unit * (z - from);
  return Nothing{};
}

bool has_area(const Component& part) {
  return std::all_of(part.triangles.begin(), part.triangles.end(), [&](const std::array<int, 3>& t) {
    return (part.at[t[1]] - part.at[t[0]]).cross(part.at[t[2]] - part.at[t[0]]).norm() > 0.0;
  });
}

}  // namespace

Result<Eigen::Matrix2Xd> flatten(const Eigen::Matrix3Xd& surface, const Eigen::Matrix3Xi& triangles, Flattening method,
                                 const ElementNames& names) {
  if (surface.cols() > kMaxFlattenedVertices) {
    return refuse("MESH_TOO_LARGE", std::to_string(surface.cols()) +
                                        " vertices; material coordinates can be computed for at most " +
                                        std::to_string(kMaxFlattenedVertices) + ": give texture coordinates");
  }
  std::vector<Component> components = split_components(surface, triangles);
  Eigen::Matrix2Xd material(2, surface.cols());
  double right = 0.0;
  for (Component& part : components) {
    KERF_TRY(find_borders(part, names));
    if (!has_area(part)) return refuse("MESH_DEGENERATE_TRIANGLE", "a triangle of the surface has no area");
    std::vector<Complex> mapped = method == Flattening::kConformal ? map_conformally(part) : map_into_circle(part);
    if (mapped.empty())
      return refuse("MESH_NOT_FLATTENABLE", "no map to the plane was found; give texture coordinates");
    KERF_TRY(align(part, names, mapped));
    Complex shift(0.0, 0.0);
    if (components.size() > 1) {
      Eigen::AlignedBox2d box;
      for (const Complex& z : mapped) box.extend(Eigen::Vector2d(z.real(), z.imag()));
      const double gap = right > 0.0 ? kGap * box.sizes().maxCoeff() : 0.0;
      shift = Complex(right + gap - box.min().x(), -box.min().y());
      right += gap + box.sizes().x();
    }
    for (std::size_t v = 0; v < mapped.size(); ++v) {
      const Complex at = mapped[v] + shift;
      material.col(part.vertices[v]) = Eigen::Vector2d(at.real(), at.imag());
    }
  }
  return material;
}

}  // namespace kerf::mesh
