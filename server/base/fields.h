#pragma once

#include <array>
#include <bit>
#include <concepts>
#include <cstddef>
#include <cstdint>
#include <cstring>
#include <memory>
#include <optional>
#include <span>
#include <string>
#include <string_view>
#include <tuple>
#include <type_traits>
#include <utility>
#include <vector>

#include "server/base/state_hash.h"

namespace kerf {

// Lists the members of a type, once for all that must visit each of them: to write, to read and to hash. A
// specialisation has one static function, which takes constant and other objects:
//   of(auto& value)              returns std::tie() of the members; a structured binding names all, so that a new
//   member
//                                does not compile until it is listed
//   visit(auto& visitor, auto& value)   instead, where not all members are visited, or not all alike
template <class T>
struct Fields;

namespace fields {

template <class T>
inline constexpr bool kIsVector = false;
template <class T>
inline constexpr bool kIsVector<std::vector<T>> = true;
template <>
inline constexpr bool kIsVector<std::string> = true;
template <class T>
inline constexpr bool kIsOptional = false;
template <class T>
inline constexpr bool kIsOptional<std::optional<T>> = true;
template <class T>
inline constexpr bool kIsShared = false;
template <class T>
inline constexpr bool kIsShared<std::shared_ptr<const T>> = true;
template <class T>
inline constexpr bool kIsArray = false;
template <class T, std::size_t n>
inline constexpr bool kIsArray<std::array<T, n>> = true;
template <class T>
inline constexpr bool kIsTuple = false;
template <class... T>
inline constexpr bool kIsTuple<std::tuple<T...>> = true;
template <class T>
inline constexpr bool kIsPair = false;
template <class A, class B>
inline constexpr bool kIsPair<std::pair<A, B>> = true;

// A number, whose bytes in memory are those written.
template <class T>
inline constexpr bool kIsPlain = (std::is_arithmetic_v<T> || std::is_enum_v<T>)&&!std::is_same_v<T, bool>;
// A matrix of Eigen, or a VertexField: numbers in one piece, column by column.
template <class T>
concept Matrix = requires(T& value) {
  value.data();
  value.rows();
  value.cols();
  value.resize(value.rows(), value.cols());
};

static_assert(std::endian::native == std::endian::little, "numbers are written as they are in memory");

}  // namespace fields

template <class Visitor>
inline constexpr bool kReads = std::remove_reference_t<Visitor>::kReads;

// Visits every number of a value, in order. A visitor has these members:
//   static constexpr bool kReads           true: values are set
//   void plain(T* values, std::size_t n)   visits numbers; T is constant unless kReads
//   void flag(bool& value)                 visits a bool, constant unless kReads
//   void presence(bool& value)             visits the bool that tells whether an optional value is there
//   std::size_t count(std::size_t n, std::size_t size)   visits a number of elements of at least `size` bytes each, and
//                                          returns it; 0 if a reader has fewer bytes left
//   bool failed()                          true if a reader met what no writer makes
//   T make<T>()                            the value of which a reader overwrites the fields
template <class Visitor, class T>
void visit(Visitor& visitor, T& value) {
  using Value = std::remove_const_t<T>;
  if constexpr (std::is_same_v<Value, bool>) {
    visitor.flag(value);
  } else if constexpr (fields::kIsPlain<Value>) {
    visitor.plain(&value, 1);
  } else if constexpr (fields::kIsVector<Value>) {
    using Element = typename Value::value_type;
    if constexpr (fields::kIsPlain<Element>) {
      const std::size_t count = visitor.count(value.size(), sizeof(Element));
      if constexpr (Visitor::kReads) value.resize(count);
      visitor.plain(value.data(), count);
    } else if constexpr (Visitor::kReads) {
      value.clear();
      const std::size_t count = visitor.count(0, 1);
      for (std::size_t i = 0; i < count && !visitor.failed(); ++i) {
        value.push_back(visitor.template make<Element>());
        visit(visitor, value.back());
      }
    } else {
      visitor.count(value.size(), 1);
      for (auto& element : value) visit(visitor, element);
    }
  } else if constexpr (fields::kIsArray<Value>) {
    if constexpr (fields::kIsPlain<typename Value::value_type>) {
      visitor.plain(value.data(), value.size());
    } else {
      for (auto& element : value) visit(visitor, element);
    }
  } else if constexpr (fields::kIsPair<Value>) {
    visit(visitor, value.first);
    visit(visitor, value.second);
  } else if constexpr (fields::kIsOptional<Value>) {
    bool is_there = value.has_value();
    visitor.presence(is_there);
    if constexpr (Visitor::kReads) {
      value.reset();
      if (is_there) value = visitor.template make<typename Value::value_type>();
    }
    if (is_there) visit(visitor, *value);
  } else if constexpr (fields::kIsShared<Value>) {
    bool is_there = value != nullptr;
    visitor.presence(is_there);
    if constexpr (Visitor::kReads) {
      using Element = std::remove_const_t<typename Value::element_type>;
      value.reset();
      if (!is_there) return;
      auto made = std::make_shared<Element>(visitor.template make<Element>());
      visit(visitor, *made);
      value = std::move(made);
    } else if (is_there) {
      visit(visitor, *value);
    }
  } else if constexpr (fields::Matrix<Value>) {
    using Index = decltype(value.cols());
    std::size_t columns = static_cast<std::size_t>(value.cols());
    const auto rows = static_cast<std::size_t>(value.rows());
    if constexpr (Value::SizeAtCompileTime == -1) {  // the number of columns is dynamic
      columns = visitor.count(columns, rows * sizeof(typename Value::Scalar));
      if constexpr (Visitor::kReads) value.resize(value.rows(), static_cast<Index>(columns));
    }
    visitor.plain(value.data(), rows * columns);
  } else if constexpr (fields::kIsTuple<Value>) {
    std::apply([&](auto&... part) { (visit(visitor, part), ...); }, value);
  } else if constexpr (requires { Fields<Value>::visit(visitor, value); }) {
    Fields<Value>::visit(visitor, value);
  } else {
    std::apply([&](auto&... field) { (visit(visitor, field), ...); }, Fields<Value>::of(value));
  }
}

// Appends little-endian numbers to a string.
class FieldWriter {
 public:
  static constexpr bool kReads = false;
  template <class T>
  void plain(const T* values, std::size_t n) {
    if (n > 0) bytes_.append(reinterpret_cast<const char*>(values), n * sizeof(T));
  }
  void flag(const bool& value) { bytes_.push_back(value ? '\1' : '\0'); }
  void presence(const bool& value) { flag(value); }
  std::size_t count(std::size_t n, std::size_t /*size*/) {
    const std::uint64_t written = n;
    plain(&written, 1);
    return n;
  }
  [[nodiscard]] bool failed() const { return false; }
  [[nodiscard]] const std::string& bytes() const { return bytes_; }
  // Forgets what was written, and keeps the memory.
  void clear() { bytes_.clear(); }

 private:
  std::string bytes_;
};

// Hashes what FieldWriter would write.
class FieldHasher {
 public:
  static constexpr bool kReads = false;
  template <class T>
  void plain(const T* values, std::size_t n) {
    hash_.add_span(std::span<const T>(values, n));
  }
  void flag(const bool& value) { hash_.add(value); }
  void presence(const bool& value) { flag(value); }
  std::size_t count(std::size_t n, std::size_t /*size*/) {
    hash_.add(static_cast<std::uint64_t>(n));
    return n;
  }
  [[nodiscard]] bool failed() const { return false; }
  [[nodiscard]] std::uint64_t value() const { return hash_.value(); }

 private:
  StateHash hash_;
};

// Reads what FieldWriter wrote. After the first fault everything read is 0, and nothing more is taken. Memory grows
// with the bytes that are there, never with a number among them.
class FieldReader {
 public:
  static constexpr bool kReads = true;
  explicit FieldReader(std::string_view bytes) : rest_(bytes) {}

  template <class T>
  void plain(T* values, std::size_t n) {
    if (n == 0) return;
    if (failed_ || n > rest_.size() / sizeof(T)) {
      failed_ = true;
      std::memset(values, 0, n * sizeof(T));
      return;
    }
    std::memcpy(values, rest_.data(), n * sizeof(T));
    rest_.remove_prefix(n * sizeof(T));
  }
  void flag(bool& value) {
    std::uint8_t byte = 0;
    plain(&byte, 1);
    failed_ = failed_ || byte > 1;
    value = byte == 1 && !failed_;
  }
  void presence(bool& value) { flag(value); }
  std::size_t count(std::size_t /*n*/, std::size_t size) {
    std::uint64_t written = 0;
    plain(&written, 1);
    failed_ = failed_ || written > rest_.size() / size;
    return failed_ ? 0 : static_cast<std::size_t>(written);
  }
  [[nodiscard]] bool failed() const { return failed_; }
  // Returns true if all bytes were read, and none was at fault.
  [[nodiscard]] bool is_done() const { return !failed_ && rest_.empty(); }
  template <class T>
  [[nodiscard]] T make() const {
    return {};
  }

 private:
  std::string_view rest_;
  bool failed_ = false;
};

}  // namespace kerf
