#include "server/core/cut/path_flattening.h"

#include <algorithm>
#include <cmath>
#include <limits>
#include <queue>
#include <utility>

#include "server/core/cut/arc.h"

namespace kerf::cut {
namespace {

using Eigen::Vector2d;

constexpr int kEndOfList = -1;
constexpr int kMaxDepth = 64;       // most halvings of a piece down to one chord; 2^-64 of a piece is below any
                                    // rounding
constexpr double kNoise = 1.0e-14;  // -; size of a loop that is only rounding, over the largest coordinate

// All pieces of a curve as linked lists of chords, one list per subpath. The chords of all lists are refined together.
class ChordLists {
 public:
  explicit ChordLists(double tolerance) : tolerance_(tolerance) {}

  void add(const SubpathPieces& subpath) {
    rounding_ = std::max(rounding_, subpath.rounding_m);
    heads_.push_back(static_cast<int>(chords_.size()));
    for (const RationalPiece& piece : subpath.pieces) add(piece);
    chords_.back().next = kEndOfList;
  }

  // Splits the chord farthest from its piece until none is too far, the limit is met, or only rounding is left.
  void refine() {
    while (!worst_.empty() && chords_.size() < kMaxPathChords) {
      const int at = worst_.top().second;
      worst_.pop();
      const Chord whole = chords_[static_cast<std::size_t>(at)];
      if (whole.depth >= kMaxDepth) continue;
      const auto [left, right] = split(whole.piece, balanced_parameter(whole.piece));
      chords_[static_cast<std::size_t>(at)].next = static_cast<int>(chords_.size());
      replace(at, left, whole.depth + 1);
      chords_.push_back({{}, 0.0, 0, whole.next});
      replace(static_cast<int>(chords_.size()) - 1, right, whole.depth + 1);
    }
  }

  [[nodiscard]] FlatCurve result() const {
    FlatCurve flat;
    int deepest = 0;
    for (const Chord& chord : chords_) {
      flat.deviation_m = std::max(flat.deviation_m, chord.deviation);
      deepest = std::max(deepest, chord.depth);
    }
    // Adds a bound on rounding. Each level of de Casteljau rounds numerator and weight by at most 3 epsilon of the
    // largest coordinate, and the projection by 3 more.
    const double levels = 8.0 * (deepest + 2);
    flat.deviation_m += levels * std::numeric_limits<double>::epsilon() * largest_ + rounding_;
    for (const int head : heads_) {
      Stroke stroke;
      stroke.points.push_back(chords_[static_cast<std::size_t>(head)].piece.start);
      for (int at = head; at != kEndOfList; at = chords_[static_cast<std::size_t>(at)].next) {
        const Vector2d& end = chords_[static_cast<std::size_t>(at)].piece.end;
        if (stroke.points.back() != end) stroke.points.push_back(end);
      }
      if (stroke.points.size() >= 2) flat.strokes.push_back(std::move(stroke));
    }
    return flat;
  }

 private:
  struct Chord {
    RationalPiece piece;
    double deviation = 0.0;  // m; bound on the distance between chord and piece
    int depth = 0;           // number of splits that led to this chord
    int next = kEndOfList;
  };

  void add(const RationalPiece& piece) {
    for (int i = 0; piece.degree > 1 && i <= piece.degree; ++i) {
      largest_ = std::max(largest_, projected(piece.points[static_cast<std::size_t>(i)]).cwiseAbs().maxCoeff());
    }
    RationalPiece rest = piece;
    double done = 0.0;
    for (const double t : cusp_parameters(piece)) {
      const auto [left, right] = split(rest, (t - done) / (1.0 - done));
      append(left, 1);
      rest = right;
      done = t;
    }
    append(rest, done > 0.0 ? 1 : 0);
  }

  void append(const RationalPiece& piece, int depth) {
    const int at = static_cast<int>(chords_.size());
    chords_.push_back({{}, 0.0, 0, at + 1});
    replace(at, piece, depth);
  }

  void replace(int at, const RationalPiece& piece, int depth) {
    Chord& chord = chords_[static_cast<std::size_t>(at)];
    chord.piece = piece;
    chord.depth = depth;
    chord.deviation = deviation_bound(piece);
    // A piece that ends where it starts has a single point as chord, so it is divided even within the tolerance. A loop
    // as small as rounding is not divided.
    const bool loop = piece.start == piece.end && chord.deviation > kNoise * largest_;
    if (chord.deviation > tolerance_ || loop) worst_.emplace(chord.deviation, at);
  }

  double tolerance_;
  std::vector<Chord> chords_;
  std::vector<int> heads_;
  std::priority_queue<std::pair<double, int>> worst_;
  double largest_ = 0.0;   // m, largest coordinate of a control point
  double rounding_ = 0.0;  // m, bound on the rounding of arcs
};

// Collects the rational pieces of a subpath.
class Pieces {
 public:
  explicit Pieces(const Vector2d& start) : at_(start) {}

  void add(const LineTo& line) {
    if (line.end != at_) append(piece_of(at_, line));
  }
  void add(const QuadraticTo& quadratic) { append(piece_of(at_, quadratic)); }
  void add(const CubicTo& cubic) { append(piece_of(at_, cubic)); }
  void add(const ArcTo& arc) { add(arc_pieces(at_, arc)); }
  void add(const ArcPieces& arc) {
    for (const QuadraticTo& piece : arc.segments) add(piece);
    result_.rounding_m = std::max(result_.rounding_m, arc.rounding_m);
  }
  [[nodiscard]] SubpathPieces take() { return std::move(result_); }

 private:
  void append(const RationalPiece& piece) {
    result_.pieces.push_back(piece);
    at_ = piece.end;
  }

  Vector2d at_;
  SubpathPieces result_;
};

}  // namespace

SubpathPieces pieces_of(const Subpath& subpath) {
  Pieces pieces(subpath.start);
  for (const Segment& segment : subpath.segments) {
    std::visit([&pieces](const auto& each) { pieces.add(each); }, segment);
  }
  if (subpath.closed) pieces.add(LineTo{subpath.start});
  return pieces.take();
}

SubpathPieces pieces_of(const Ellipse& ellipse) {
  const EllipsePieces quarters = ellipse_pieces(ellipse);
  Pieces pieces(quarters.start);
  pieces.add(quarters.quarters);
  return pieces.take();
}

FlatCurve flatten_ellipse(const Ellipse& ellipse, double tolerance) {
  ChordLists lists(tolerance);
  lists.add(pieces_of(ellipse));
  lists.refine();
  return lists.result();
}

FlatCurve flatten_path(const Path& path, double tolerance) {
  ChordLists lists(tolerance);
  for (const Subpath& subpath : path.subpaths) {
    const SubpathPieces pieces = pieces_of(subpath);
    if (!pieces.pieces.empty()) lists.add(pieces);
  }
  lists.refine();
  return lists.result();
}

}  // namespace kerf::cut
