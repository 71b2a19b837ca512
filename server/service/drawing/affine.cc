#include "server/service/drawing/affine.h"

#include <utility>
#include <variant>

#include "server/core/cut/arc.h"

namespace kerf::drawing {
namespace {

using Eigen::Vector2d;

// Builds one transformed subpath, segment by segment.
class Mapper {
 public:
  Mapper(const cut::Subpath& from, const Affine& map) : map_(map), at_(from.start) {
    result_.start = map(from.start);
    result_.closed = from.closed;
    for (const cut::Segment& segment : from.segments) {
      std::visit([this](const auto& each) { add(each); }, segment);
    }
  }
  [[nodiscard]] cut::Subpath take() { return std::move(result_); }

 private:
  void add(const cut::LineTo& line) {
    result_.segments.emplace_back(cut::LineTo{map_(line.end)});
    at_ = line.end;
  }
  void add(const cut::QuadraticTo& quadratic) {
    result_.segments.emplace_back(cut::QuadraticTo{map_(quadratic.control), map_(quadratic.end), quadratic.weights});
    at_ = quadratic.end;
  }
  void add(const cut::CubicTo& cubic) {
    result_.segments.emplace_back(
        cut::CubicTo{{map_(cubic.controls[0]), map_(cubic.controls[1])}, map_(cubic.end), cubic.weights});
    at_ = cubic.end;
  }
  void add(const cut::ArcTo& arc) {
    const cut::ArcPieces pieces = cut::arc_pieces(at_, arc);
    for (const cut::QuadraticTo& piece : pieces.segments) add(piece);
  }

  const Affine& map_;
  Vector2d at_;  // The current point before the map.
  cut::Subpath result_;
};

}  // namespace

Affine translation(const Vector2d& by) {
  return {Eigen::Matrix2d::Identity(), by};
}

cut::Subpath transformed(const cut::Subpath& subpath, const Affine& map) {
  return Mapper(subpath, map).take();
}

}  // namespace kerf::drawing
