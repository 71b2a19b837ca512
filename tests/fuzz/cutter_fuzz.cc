// Bytes -> a sheet and a few cuts on it, each audited. Stops the fuzzer where anything is wrong.
#include <cmath>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <optional>
#include <vector>

#include "server/base/check.h"
#include "server/core/cut/cut.h"
#include "tests/audit/audited_cut.h"
#include "tests/support/meshes.h"

namespace {

using namespace kerf;

// Takes values off the front of the input; zeros when it is used up.
class Bytes {
 public:
  Bytes(const std::uint8_t* data, std::size_t size) : data_(data), size_(size) {}

  template <typename T>
  T take() {
    T value{};
    const std::size_t count = std::min(sizeof(T), size_);
    std::memcpy(&value, data_, count);
    data_ += count;
    size_ -= count;
    return value;
  }
  [[nodiscard]] bool empty() const { return size_ == 0; }

  // A place on the unit square or around it: on a lattice of 1/64, of 1/65536 around that, or any double at all.
  Eigen::Vector2d place() {
    const auto form = take<std::uint8_t>();
    if (form == 255) {
      const double x = take<double>();
      return {x, take<double>()};
    }
    const double x = take<std::int8_t>() / 64.0;
    Eigen::Vector2d at(x, take<std::int8_t>() / 64.0);
    if (form % 2 == 1) {
      const double fine_x = take<std::int16_t>() * 0x1.0p-22;
      at += Eigen::Vector2d(fine_x, take<std::int16_t>() * 0x1.0p-22);
    }
    return at;
  }

 private:
  const std::uint8_t* data_;
  std::size_t size_;
};

cut::Curve any_curve(Bytes& bytes) {
  const auto form = bytes.take<std::uint8_t>();
  const std::size_t count = 2 + form / 4 % 8;
  std::vector<Eigen::Vector2d> points;
  for (std::size_t i = 0; i < 3 * count + 1; ++i) {
    points.push_back(bytes.place());
    if (form % 4 != 0 && points.size() == count) break;
  }
  if (form % 4 == 0) return cut::CubicBezier{points};
  if (form % 4 == 1) return cut::Circle{points[0], (points[1] - points[0]).norm()};
  if (form % 4 == 2) points.push_back(points.front());
  return cut::Polyline{points};
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  Bytes bytes(data, size);
  const auto form = bytes.take<std::uint8_t>();
  const int vertices = 2 + form % 8;
  mesh::TriangleMesh mesh = form >= 128 ? test::jittered_grid(vertices, form) : test::grid(vertices);
  for (int i = 0; i < 4 && !bytes.empty(); ++i) {
    cut::CutRequest request{any_curve(bytes), {}, {}};
    const auto options = bytes.take<std::uint8_t>();
    request.options.relax = options % 2 == 0;
    if (options % 4 >= 2) request.options.min_angle_deg = 0.0;
    if (options / 64 % 2 == 1) request.options.width_m = std::exp2(-bytes.take<std::uint8_t>() / 8.0);
    request.options.max_new_triangles = 4'000;
    if (options >= 128) request.fixed_vertices = {0, mesh.num_vertices() / 2};
    const audit::AuditedCut done = audit::cut_and_audit(mesh, request, audit::kDeepest);
    if (done.flaw) KERF_CHECK(false, done.flaw->c_str());
    KERF_CHECK(done.reason != "CUT_NOT_REPRESENTABLE", "a cut that is refused for its rounding");
  }
  return 0;
}
