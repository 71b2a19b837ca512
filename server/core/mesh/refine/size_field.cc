#include "server/core/mesh/refine/size_field.h"

#include <algorithm>
#include <cmath>
#include <utility>

namespace kerf::mesh {
namespace {

using Eigen::Vector2d;

constexpr std::int32_t kLeafSources = 4;

double distance(const Vector2d& p, const SizeSource& source) {
  const Vector2d along = source.b - source.a;
  const Vector2d offset = p - source.a;
  const double squared_length = along.squaredNorm();
  if (squared_length == 0.0) return offset.norm();
  return (offset - std::clamp(offset.dot(along) / squared_length, 0.0, 1.0) * along).norm();
}

}  // namespace

SizeField::SizeField(double largest, std::vector<SizeSource> sources)
    : largest_(largest), sources_(std::move(sources)) {
  for (const SizeSource& source : sources_) steepest_growth_ = std::max(steepest_growth_, source.growth);
  if (!sources_.empty()) build(0, static_cast<std::int32_t>(sources_.size()));
}

std::int32_t SizeField::build(std::int32_t begin, std::int32_t end) {
  const auto index = static_cast<std::int32_t>(nodes_.size());
  Node node;
  node.begin = begin, node.end = end;
  node.least_length = sources_[begin].length, node.least_growth = sources_[begin].growth;
  for (std::int32_t i = begin; i < end; ++i) {
    node.box.extend(sources_[i].a);
    node.box.extend(sources_[i].b);
    node.least_length = std::min(node.least_length, sources_[i].length);
    node.least_growth = std::min(node.least_growth, sources_[i].growth);
  }
  nodes_.push_back(node);
  if (end - begin <= kLeafSources) return index;
  const Vector2d sizes = node.box.sizes();
  const int axis = sizes.x() >= sizes.y() ? 0 : 1;
  const std::int32_t middle = begin + (end - begin) / 2;
  std::nth_element(
      sources_.begin() + begin, sources_.begin() + middle, sources_.begin() + end,
      [axis](const SizeSource& p, const SizeSource& q) { return p.a[axis] + p.b[axis] < q.a[axis] + q.b[axis]; });
  build(begin, middle);
  const std::int32_t right = build(middle, end);
  nodes_[index].right = right;
  return index;
}

double SizeField::at(const Vector2d& position) const {
  double least = largest_;
  if (!nodes_.empty()) descend(0, position, least);
  return least;
}

void SizeField::descend(std::int32_t index, const Vector2d& position, double& least) const {
  const Node& node = nodes_[index];
  if (node.right < 0) {
    for (std::int32_t i = node.begin; i < node.end; ++i) {
      least = std::min(least, sources_[i].length + sources_[i].growth * distance(position, sources_[i]));
    }
    return;
  }
  const auto bound = [&](std::int32_t child) {
    return nodes_[child].least_length + nodes_[child].least_growth * nodes_[child].box.exteriorDistance(position);
  };
  std::int32_t near = index + 1, far = node.right;
  double near_bound = bound(near), far_bound = bound(far);
  if (far_bound < near_bound) {
    std::swap(near, far);
    std::swap(near_bound, far_bound);
  }
  if (near_bound < least) descend(near, position, least);
  if (far_bound < least) descend(far, position, least);
}

}  // namespace kerf::mesh
