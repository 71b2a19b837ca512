#include "server/core/mesh/edge_lengths.h"

#include <algorithm>
#include <cmath>
#include <limits>

#include "server/core/mesh/mesh_data.h"

namespace kerf::mesh {
namespace {

constexpr std::int32_t kMaxCells = 512;  // most columns, and most rows
constexpr int kMaxExponent = 40;         // largest magnitude of an exponent

struct Cell {
  std::int32_t column = 0, row = 0;
};

Cell cell_of(const EdgeLengths& lengths, const Eigen::Vector2d& position) {
  const Eigen::Vector2d share = (position - lengths.bounds.min()).cwiseQuotient(lengths.bounds.sizes());
  const auto index = [](double value, std::int32_t count) {
    return static_cast<std::int32_t>(std::clamp(value * count, 0.0, count - 1.0));
  };
  return {index(share.x(), lengths.columns), index(share.y(), lengths.rows)};
}

// Returns sqrt(2 area), m: the leg of an isosceles right triangle of the same area.
double length_of(const TriangleRecord& triangle, std::span<const PointRecord> points, const Lattice& lattice) {
  const auto at = [&](int k) -> const LatticePoint& {
    return points[static_cast<std::size_t>(triangle.points[static_cast<std::size_t>(k)])].at;
  };
  return lattice.spacing * std::sqrt(static_cast<double>(doubled_area(at(0), at(1), at(2))));
}

}  // namespace

EdgeLengths EdgeLengths::of(std::span<const TriangleRecord> triangles, std::span<const PointRecord> points,
                            const Lattice& lattice, const Eigen::AlignedBox2d& bounds) {
  EdgeLengths lengths;
  lengths.bounds = bounds;
  double sum = 0.0;
  for (const TriangleRecord& triangle : triangles) sum += length_of(triangle, points, lattice);
  lengths.mean = sum / static_cast<double>(triangles.size());
  const Eigen::Vector2d sizes = bounds.sizes();
  const double cell = std::max(lengths.mean, sizes.maxCoeff() / kMaxCells);
  lengths.columns = std::max(1, static_cast<std::int32_t>(std::ceil(sizes.x() / cell)));
  lengths.rows = std::max(1, static_cast<std::int32_t>(std::ceil(sizes.y() / cell)));
  const auto count = static_cast<std::size_t>(lengths.columns) * static_cast<std::size_t>(lengths.rows);
  std::vector<double> sums(count, 0.0);
  std::vector<double> counts(count, 0.0);
  for (const TriangleRecord& triangle : triangles) {
    Eigen::AlignedBox2d box;
    for (const PointId p : triangle.points) box.extend(lattice.position(points[static_cast<std::size_t>(p)].at));
    const Cell low = cell_of(lengths, box.min());
    const Cell high = cell_of(lengths, box.max());
    const double length = length_of(triangle, points, lattice);
    for (std::int32_t row = low.row; row <= high.row; ++row) {
      for (std::int32_t column = low.column; column <= high.column; ++column) {
        const auto index = static_cast<std::size_t>(row * lengths.columns + column);
        sums[index] += length;
        counts[index] += 1.0;
      }
    }
  }
  lengths.exponents.resize(count, 0);
  for (std::size_t i = 0; i < count; ++i) {
    if (counts[i] == 0.0) continue;  // no triangle near: a hole
    const double ratio = sums[i] / counts[i] / lengths.mean;
    lengths.exponents[i] =
        static_cast<std::int8_t>(std::clamp(std::ilogb(ratio * std::sqrt(2.0)), -kMaxExponent, kMaxExponent));
  }
  if (std::all_of(lengths.exponents.begin(), lengths.exponents.end(), [](std::int8_t e) { return e == 0; })) {
    lengths.exponents.clear();
    lengths.columns = lengths.rows = 0;
    return lengths;
  }
  lengths.least_exponent = *std::min_element(lengths.exponents.begin(), lengths.exponents.end());
  return lengths;
}

double EdgeLengths::at(const Eigen::Vector2d& position) const {
  if (is_uniform()) return mean;
  const Cell cell = cell_of(*this, position);
  return std::ldexp(mean, exponents[static_cast<std::size_t>(cell.row * columns + cell.column)]);
}

double EdgeLengths::least() const {
  return std::ldexp(mean, least_exponent);
}

double EdgeLengths::least_in(const Eigen::AlignedBox2d& box) const {
  if (is_uniform()) return mean;
  const Cell low = cell_of(*this, box.min());
  const Cell high = cell_of(*this, box.max());
  std::int8_t least = exponents[static_cast<std::size_t>(low.row * columns + low.column)];
  for (std::int32_t row = low.row; row <= high.row; ++row) {
    const auto first = exponents.begin() + static_cast<std::ptrdiff_t>(row * columns);
    least = std::min(least, *std::min_element(first + low.column, first + high.column + 1));
  }
  return std::ldexp(mean, least);
}

double EdgeLengths::resolution() const {
  if (is_uniform()) return std::numeric_limits<double>::infinity();
  return std::min(bounds.sizes().x() / columns, bounds.sizes().y() / rows);
}

bool operator==(const EdgeLengths& a, const EdgeLengths& b) {
  return a.mean == b.mean && a.columns == b.columns && a.rows == b.rows && a.exponents == b.exponents &&
         a.bounds.min() == b.bounds.min() && a.bounds.max() == b.bounds.max();
}

}  // namespace kerf::mesh
