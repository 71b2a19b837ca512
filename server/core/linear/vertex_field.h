#pragma once

#include <algorithm>
#include <cstddef>
#include <memory>
#include <new>
#include <utility>

#include <Eigen/Core>

namespace kerf::linear {

// Three numbers a vertex, 3 x V, used like an Eigen::Matrix3Xd but with spare capacity. Thanks to it, a cut that adds a
// few vertices to a large sheet does not copy the others. Eigen's own matrices have no spare capacity, so each resize
// copies.
class VertexField : public Eigen::Map<Eigen::Matrix3Xd, Eigen::Aligned16> {
  using Base = Eigen::Map<Eigen::Matrix3Xd, Eigen::Aligned16>;

 public:
  VertexField() : Base(nullptr, 3, 0) {}
  explicit VertexField(Eigen::Index num_vertices) : VertexField() { resize(num_vertices); }  // uninitialised
  template <typename Derived>
  VertexField(const Eigen::MatrixBase<Derived>& values) : VertexField() {  // NOLINT(*-explicit-*): as of matrices
    *this = values;
  }
  VertexField(const VertexField& other) : VertexField() { *this = other; }
  VertexField(VertexField&& other) noexcept : VertexField() { swap(other); }
  VertexField& operator=(const VertexField& other) {
    if (this == &other) return *this;
    resize(other.cols());
    Base::operator=(other);
    return *this;
  }
  VertexField& operator=(VertexField&& other) noexcept {
    swap(other);
    return *this;
  }
  // Assigns `values`. As with matrices, `values` may refer to this field only coefficient by coefficient.
  template <typename Derived>
  VertexField& operator=(const Eigen::MatrixBase<Derived>& values) {
    resize(values.cols());
    Base::operator=(values);
    return *this;
  }
  ~VertexField() = default;

  [[nodiscard]] Eigen::Index capacity() const { return capacity_; }  // vertices
  // Keeps the existing columns; new ones are uninitialised. Copies only beyond the capacity, which then grows by half,
  // so the number of copies is logarithmic in the size.
  void resize(Eigen::Index num_vertices) {
    if (num_vertices > capacity_) {
      reserve(capacity_ == 0 ? num_vertices : std::max(num_vertices, capacity_ + capacity_ / 2));
    }
    view(num_vertices);
  }
  void reserve(Eigen::Index num_vertices) {
    if (num_vertices <= capacity_) return;
    // Aligned to 16 bytes. A large block is not touched, and takes no memory, before it is used.
    Storage grown(static_cast<double*>(::operator new(3 * sizeof(double) * static_cast<std::size_t>(num_vertices))));
    std::copy_n(data(), size(), grown.get());
    storage_ = std::move(grown);
    capacity_ = num_vertices;
    view(cols());
  }

 private:
  struct Free {
    void operator()(double* block) const { ::operator delete(block); }
  };
  using Storage = std::unique_ptr<double, Free>;

  // Repoints the map by constructing it in place, as Eigen documents.
  void view(Eigen::Index num_vertices) { new (static_cast<Base*>(this)) Base(storage_.get(), 3, num_vertices); }
  void swap(VertexField& other) noexcept {
    const Eigen::Index num_vertices = cols();
    storage_.swap(other.storage_);
    std::swap(capacity_, other.capacity_);
    view(other.cols());
    other.view(num_vertices);
  }

  Storage storage_;
  Eigen::Index capacity_ = 0;
};

}  // namespace kerf::linear
