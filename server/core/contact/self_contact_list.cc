// Members of SelfContact that keep the list of pairs that may touch.
#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "server/core/contact/self_contact.h"
#include "server/core/contact/stray_bounds.h"

namespace kerf::contact {

using mesh::VertexId;

namespace {

constexpr int kSearchAhead = 64;  // substeps for which a list with pairs is made at most
constexpr int kLeastAhead = 8;    // substeps
constexpr double kStrayed = 0.5;  // -, of its slack that a vertex should stray before the list ends
constexpr float kMost = 2.0F;     // -, largest slack over that at first

}  // namespace

Eigen::Vector3d SelfContact::smooth_velocity(const linear::VertexField& v, VertexId at) const {
  Eigen::Vector3d sum = v.col(at);
  const std::span<const VertexId> neighbours = tree_.features().neighbours_of(at);
  for (const VertexId i : neighbours) sum += v.col(i);
  return sum / static_cast<double>(1 + neighbours.size());
}

void SelfContact::follow_paths(const linear::VertexField& x) {
  const std::vector<VertexId>& vertices = tree_.features().vertices;
  const double since = step_.h * (next_phase_ - std::max(substep_, list_begin_));
  const auto way = [&](VertexId v) -> Eigen::Vector3d { return x.col(v) - x_then_.col(v) - since * v_list_.col(v); };
  Eigen::Vector3d mean = Eigen::Vector3d::Zero();
  for (const VertexId v : vertices) mean += way(v);
  mean /= static_cast<double>(vertices.size());
  for (const VertexId v : vertices) path_[static_cast<std::size_t>(v)] += static_cast<float>((way(v) - mean).norm());
  elapsed_ = static_cast<float>(step_.h * (next_phase_ - list_begin_));
}

void SelfContact::find_strayed(const linear::VertexField& x, const linear::VertexField& v, double ahead, double share) {
  const double since = step_.h * (next_phase_ - list_begin_);
  const std::vector<VertexId>& vertices = tree_.features().vertices;
  strayed_.clear();
  // Motion that all vertices share does not count.
  if (vertices.size() == static_cast<std::size_t>(x.cols())) {
    const Stray stray = find_stray(x, v, {x_list_, v_list_}, since, ahead);
    stray_mean_ = stray.mean;
    if (stray.most <= share * least_slack_) return;
  }
  stray_mean_.setZero();
  for (const VertexId i : vertices) {
    const Eigen::Vector3d on_list = v_list_.col(i);
    Eigen::Vector3d stray = x.col(i) - x_list_.col(i) - since * on_list;
    if (ahead > 0.0) stray += ahead * (v.col(i) - on_list);
    stray_.col(i) = stray;
    stray_mean_ += stray;
  }
  stray_mean_ /= static_cast<double>(std::max<std::size_t>(vertices.size(), 1));
  for (const VertexId i : vertices) {
    const double allowed = share * static_cast<double>(slack_[static_cast<std::size_t>(i)]);
    if ((stray_.col(i) - stray_mean_).squaredNorm() > allowed * allowed) strayed_.push_back(i);
  }
}

void SelfContact::find_strayed_of_shifted(const linear::VertexField& x) {
  const double since = step_.h * (next_phase_ - list_begin_);
  strayed_.clear();
  for (const VertexId i : shifted_) {
    const auto allowed = static_cast<double>(slack_[static_cast<std::size_t>(i)]);
    const Eigen::Vector3d stray = x.col(i) - x_list_.col(i) - since * v_list_.col(i) - stray_mean_;
    if (stray.squaredNorm() > allowed * allowed) strayed_.push_back(i);
  }
}

void SelfContact::renew_list(const linear::VertexField& x, const linear::VertexField& v, int substep) {
  if (substep < list_end_) {
    find_strayed(x, v, step_.h * std::min(interval_, list_end_ - substep), 0.8);
    if (strayed_.empty()) return;
    if (may_follow()) {
      follow_strayed(x, v, step_.h * (substep - list_begin_), true);
      return;
    }
  }
  search(x, v, substep);
}

bool SelfContact::may_follow() const {
  constexpr std::size_t kLeast = 6;  // vertices over those that stray for which a list is renewed in part
  return tree_.is_fitted() && kLeast * strayed_.size() < tree_.features().vertices.size();
}

void SelfContact::follow_strayed(const linear::VertexField& x, const linear::VertexField& v, double since,
                                 bool is_smoothed) {
  // Other vertices have strayed by what all have in common, which does not count.
  const std::vector<VertexId>& vertices = tree_.features().vertices;
  Eigen::Vector3d shift = Eigen::Vector3d::Zero(), drift = Eigen::Vector3d::Zero();
  for (const VertexId i : vertices) {
    shift += x.col(i) - x_list_.col(i) - since * v_list_.col(i);
    drift += v.col(i) - v_list_.col(i);
  }
  shift /= static_cast<double>(vertices.size());
  drift /= static_cast<double>(vertices.size());
  for (const VertexId i : strayed_) {
    is_strayed_[static_cast<std::size_t>(i)] = 1;
    v_list_.col(i) = (is_smoothed ? smooth_velocity(v, i) : Eigen::Vector3d(v.col(i))) - drift;
    x_list_.col(i) = x.col(i) - shift - since * v_list_.col(i);
  }
  ++counters_.searches;
  is_list_apart_ = false;
  tree_.follow(strayed_, x_list_, v_list_, since, thickness_, slack_, thickness_, found_);
  drop_open();
  counters_.pairs += static_cast<std::int64_t>(found_.size());
  const auto is_old = [this](const FeaturePair& pair) {
    return std::any_of(pair.vertices.begin(), pair.vertices.end(),
                       [this](VertexId i) { return is_strayed_[static_cast<std::size_t>(i)] != 0; });
  };
  std::size_t next = 0;  // of found_
  const auto keep = [&](std::size_t begin, std::size_t end) {
    for (std::size_t p = begin; p < end; ++p) {
      if (!is_old(list_.pairs[p])) continue;
      renewed_.add(list_, begin, p);
      begin = p + 1;
    }
    renewed_.add(list_, begin, end);
  };
  const auto append = [&](FeaturePair::Kind kind) {
    for (; next < found_.size() && found_[next].kind == kind; ++next) renewed_.add(found_[next]);
  };
  renewed_.clear();
  keep(0, list_.num_vertex_pairs);
  append(FeaturePair::Kind::kVertexTriangle);
  renewed_.num_vertex_pairs = renewed_.size();
  keep(list_.num_vertex_pairs, list_.size());
  append(FeaturePair::Kind::kEdgeEdge);
  renewed_.pad();
  std::swap(renewed_, list_);
  is_indexed_ = false;
  for (const VertexId i : strayed_) is_strayed_[static_cast<std::size_t>(i)] = 0;
}

void SelfContact::find_again(const linear::VertexField& x) {
  const double since = step_.h * interval_;
  way_ = (x - x_then_) / since;
  if (may_follow()) return follow_strayed(x_then_, way_, step_.h * (substep_ - list_begin_), false);
  x_list_ = x_then_;
  v_list_ = way_;
  list_begin_ = substep_;
  list_end_ = next_phase_;
  stray_mean_.setZero();
  is_list_apart_ = false;
  tree_.find_pairs({x_then_, way_, since}, thickness_, slack_, thickness_, found_);
  set_list();
}

void SelfContact::adapt_slack(const linear::VertexField& x) {
  const double since = step_.h * (next_phase_ - list_begin_);
  for (const VertexId v : tree_.features().vertices) {
    float& slack = slack_[static_cast<std::size_t>(v)];
    const float base = base_slacks_[static_cast<std::size_t>(v)];
    const auto square = static_cast<float>((x.col(v) - x_list_.col(v) - since * v_list_.col(v)).squaredNorm());
    if (square > 0.16F * slack * slack) {
      slack = std::min(2.0F * slack, kMost * base);
    } else if (square < 0.01F * slack * slack) {
      slack = std::max(0.5F * slack, base);
    }
  }
  set_least_slack();
}

void SelfContact::set_least_slack() {
  float least = std::numeric_limits<float>::infinity();
  for (const VertexId v : tree_.features().vertices) least = std::min(least, slack_[static_cast<std::size_t>(v)]);
  least_slack_ = static_cast<double>(least);
}

void SelfContact::PairList::clear() {
  pairs.clear();
  for (std::vector<std::int32_t>& of : vertices) of.clear();
  least.clear();
  speed.clear();
  limit.clear();
  safe.clear();
  seen.clear();
  separation.clear();
}

void SelfContact::PairList::add(const FeaturePair& pair) {
  pairs.push_back(pair);
  for (std::size_t i = 0; i < 4; ++i) vertices[i].push_back(pair.vertices[i]);
  least.push_back(static_cast<float>(1.000001 * pair.least));
  speed.push_back(pair.speed);
  limit.push_back(0.0F);
  safe.push_back(0.0F);
  seen.push_back(-1);
  separation.emplace_back();
}

void SelfContact::PairList::add(const PairList& from, std::size_t begin, std::size_t end) {
  const auto append = [&](const auto& of, auto& to) {
    to.insert(to.end(), of.begin() + static_cast<std::ptrdiff_t>(begin), of.begin() + static_cast<std::ptrdiff_t>(end));
  };
  append(from.pairs, pairs);
  for (std::size_t i = 0; i < 4; ++i) append(from.vertices[i], vertices[i]);
  append(from.least, least);
  append(from.speed, speed);
  append(from.limit, limit);
  append(from.safe, safe);
  append(from.seen, seen);
  append(from.separation, separation);
}

void SelfContact::PairList::pad() {
  for (std::vector<std::int32_t>& of : vertices) of.resize(size() + kLanePadding, 0);
  speed.resize(size() + kLanePadding, 0.0F);
  limit.resize(size() + kLanePadding, 0.0F);
  safe.resize(size() + kLanePadding, 0.0F);
}

void SelfContact::drop_open() {
  if (untangling_.empty()) return;
  std::erase_if(found_, [this](const FeaturePair& pair) { return untangling_.is_open(pair); });
}

void SelfContact::set_list() {
  drop_open();
  ++counters_.searches;
  counters_.pairs += static_cast<std::int64_t>(found_.size());
  list_.clear();
  for (const FeaturePair& pair : found_) list_.add(pair);
  const auto edges = std::find_if(found_.begin(), found_.end(),
                                  [](const FeaturePair& pair) { return pair.kind == FeaturePair::Kind::kEdgeEdge; });
  list_.num_vertex_pairs = static_cast<std::size_t>(edges - found_.begin());
  list_.pad();
  is_indexed_ = false;
  std::fill(path_.begin(), path_.end(), 0.0F);
  elapsed_ = 0.0F;
}

void SelfContact::search(const linear::VertexField& x, const linear::VertexField& v, int substep) {
  const std::vector<VertexId>& vertices = tree_.features().vertices;
  const int begin = list_begin_;
  if (substep > 0) adapt_slack(x);
  const bool may_be_apart = substep == 0 || list_.size() == 0;
  const bool is_list_used_up = substep == 0 || substep >= list_end_;
  x_list_ = x;
  v_list_ = v;
  list_begin_ = substep;
  list_end_ = step_.substeps;
  if (!may_be_apart || !find_list_apart(x)) {
    double vibration = 0.0;  // m^2/s^2, mean square of velocities on top of those of lines
    for (const VertexId i : vertices) {
      v_list_.col(i) = smooth_velocity(v, i);
      vibration += (v.col(i) - v_list_.col(i)).squaredNorm();
    }
    vibration /= static_cast<double>(std::max<std::size_t>(vertices.size(), 1));
    const double good = kStrayed * base_slack_ / std::max(std::sqrt(vibration) * step_.h, 1e-9);  // substeps
    int ahead = static_cast<int>(std::clamp<double>(good, kLeastAhead, kSearchAhead));
    // A list that vertices strayed from before its end had looked too far ahead.
    if (!is_list_used_up) ahead = std::min(ahead, std::max(2, 2 * (substep - begin)));
    list_end_ = std::min(substep + ahead, step_.substeps);
    tree_.find_pairs({x, v_list_, step_.h * (list_end_ - substep)}, thickness_, slack_, thickness_, found_);
  }
  set_list();
}

bool SelfContact::find_list_apart(const linear::VertexField& x) {
  found_.clear();
  wide_slack_.resize(base_slacks_.size());
  std::transform(base_slacks_.begin(), base_slacks_.end(), wide_slack_.begin(),
                 [](float base) { return kMost * base; });
  const bool was_apart = std::exchange(
      is_list_apart_, tree_.is_apart({x, v_list_, step_.h * (list_end_ - list_begin_)}, thickness_, wide_slack_));
  if (is_list_apart_) {
    std::swap(slack_, wide_slack_);
    set_least_slack();
  } else if (was_apart) {
    slack_ = base_slacks_;
    set_least_slack();
  }
  return is_list_apart_;
}

void SelfContact::look_at_due_pairs(const linear::VertexField& x, const linear::VertexField& v) {
  find_due(list_.vertices, pair_ways(), std::span(list_.limit).first(list_.size()), due_, due_ways_);
  if (!std::exchange(is_float_set_, true)) x_float_.set(x, tree_.features().vertices);
  set_floats(v, tree_.features().vertices, v_float_);
  due_distances_.resize(due_.size());
  due_closing_.resize(due_.size());
  for_due_kinds([this](const PairSelection& pairs, std::size_t first) {
    look_at(pairs, x_float_.x, v_float_, std::span(due_distances_).subspan(first, pairs.indices.size()),
            std::span(due_closing_).subspan(first, pairs.indices.size()));
  });
}

Separation SelfContact::separation_then(std::size_t pair) const {
  return list_.seen[pair] == phase_ ? list_.separation[pair]
                                    : separation(list_.pairs[pair].kind, positions_of(list_.pairs[pair], x_then_));
}

}  // namespace kerf::contact
