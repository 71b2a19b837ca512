#include "server/service/codec/packed_integers.h"

#include <algorithm>
#include <bit>
#include <cstddef>
#include <limits>

#include "server/base/check.h"

namespace kerf::codec {
namespace {

class BitWriter {
 public:
  // Appends the lowest `count` <= 32 bits of `value`, whose higher bits are zero.
  void put(std::uint32_t value, int count) {
    pending_ |= std::uint64_t{value} << num_pending_;
    num_pending_ += count;
    while (num_pending_ >= 8) {
      bytes_.push_back(static_cast<char>(pending_ & 0xffU));
      pending_ >>= 8;
      num_pending_ -= 8;
    }
  }
  std::string finish() {
    if (num_pending_ > 0) bytes_.push_back(static_cast<char>(pending_ & 0xffU));
    return std::move(bytes_);
  }

 private:
  std::string bytes_;
  std::uint64_t pending_ = 0;
  int num_pending_ = 0;
};

class BitReader {
 public:
  explicit BitReader(std::string_view bytes) : bytes_(bytes) {}

  // Reads `count` <= 32 bits. Beyond the end it returns zeros, and overrun() is true from then on.
  std::uint32_t take(int count) {
    refill();
    const auto value = static_cast<std::uint32_t>(pending_ & ((std::uint64_t{1} << count) - 1));
    drop(count);
    return value;
  }
  // Counts the ones before the next zero, which it consumes too; stops after kEscape of them.
  int take_unary() {
    refill();
    const int ones = std::min(std::countr_one(pending_), kEscape);
    drop(ones == kEscape ? kEscape : ones + 1);
    return ones;
  }
  [[nodiscard]] bool overrun() const { return num_pending_ < 0; }
  // True if only the zeros that fill the last byte are left.
  [[nodiscard]] bool at_end() const {
    return num_pending_ >= 0 && num_pending_ < 8 && at_ == bytes_.size() && pending_ == 0;
  }

 private:
  void refill() {
    while (num_pending_ >= 0 && num_pending_ <= 32 && at_ < bytes_.size()) {
      pending_ |= std::uint64_t{static_cast<unsigned char>(bytes_[at_++])} << num_pending_;
      num_pending_ += 8;
    }
  }
  void drop(int count) {
    pending_ >>= count;
    num_pending_ -= count;
  }

  std::string_view bytes_;
  std::size_t at_ = 0;
  std::uint64_t pending_ = 0;
  int num_pending_ = 0;  // Negative once more bits were read than there are.
};

// One column of a block: `count` numbers, `stride` apart.
struct Column {
  const std::uint32_t* first;
  std::size_t count;
  std::size_t stride;

  [[nodiscard]] std::uint32_t at(std::size_t row) const { return first[row * stride]; }
};

std::size_t cost_bits(const Column& column, int parameter) {
  std::size_t bits = 0;
  for (std::size_t row = 0; row < column.count; ++row) {
    const std::uint32_t quotient = column.at(row) >> parameter;
    bits += quotient < kEscape ? quotient + 1 + static_cast<std::size_t>(parameter) : kEscape + 32;
  }
  return bits;
}

// Returns the parameter k that needs the fewest bits, among a few near the best one for the mean of the column. The
// format leaves this choice to the encoder.
int choose_parameter(const Column& column, std::uint64_t sum) {
  const auto about = static_cast<int>(std::bit_width(sum / column.count));
  int best = 0;
  std::size_t best_bits = std::numeric_limits<std::size_t>::max();
  for (int parameter = std::max(0, about - 2); parameter <= std::min(30, about + 1); ++parameter) {
    const std::size_t bits = cost_bits(column, parameter);
    if (bits < best_bits) {
      best = parameter;
      best_bits = bits;
    }
  }
  return best;
}

void put_column(const Column& column, BitWriter& writer) {
  std::uint64_t sum = 0;
  for (std::size_t row = 0; row < column.count; ++row) sum += column.at(row);
  if (sum == 0) return writer.put(kAllZero, kParameterBits);
  const int parameter = choose_parameter(column, sum);
  writer.put(static_cast<std::uint32_t>(parameter), kParameterBits);
  for (std::size_t row = 0; row < column.count; ++row) {
    const std::uint32_t value = column.at(row);
    const std::uint32_t quotient = value >> parameter;
    if (quotient >= kEscape) {
      writer.put((1U << kEscape) - 1, kEscape);
      writer.put(value, 32);
    } else {
      writer.put((1U << quotient) - 1, static_cast<int>(quotient) + 1);
      writer.put(value & ((1U << parameter) - 1), parameter);
    }
  }
}

}  // namespace

std::string pack_integers(std::span<const std::uint32_t> values, std::size_t columns) {
  KERF_CHECK(columns > 0 && values.size() % columns == 0, "values that fill no whole rows");
  BitWriter writer;
  const std::size_t rows = values.size() / columns;
  for (std::size_t row = 0; row < rows; row += kBlockRows) {
    const std::size_t count = std::min<std::size_t>(kBlockRows, rows - row);
    for (std::size_t column = 0; column < columns; ++column) {
      put_column({&values[row * columns + column], count, columns}, writer);
    }
  }
  return writer.finish();
}

std::optional<std::vector<std::uint32_t>> unpack_integers(std::string_view bytes, std::size_t count,
                                                          std::size_t columns) {
  KERF_CHECK(columns > 0 && count % columns == 0, "values that fill no whole rows");
  const std::size_t rows = count / columns;
  const std::size_t blocks = (rows + kBlockRows - 1) / kBlockRows;
  if (8 * bytes.size() / kParameterBits < blocks * columns) return std::nullopt;  // each column of a block has a k
  std::vector<std::uint32_t> values(count);
  BitReader reader(bytes);
  for (std::size_t row = 0; row < rows; row += kBlockRows) {
    const std::size_t end = std::min<std::size_t>(row + kBlockRows, rows);
    for (std::size_t column = 0; column < columns; ++column) {
      const std::uint32_t parameter = reader.take(kParameterBits);
      if (parameter == kAllZero) continue;
      for (std::size_t at = row; at < end; ++at) {
        const int quotient = reader.take_unary();
        values[at * columns + column] = quotient == kEscape ? reader.take(32)
                                                            : (static_cast<std::uint32_t>(quotient) << parameter) |
                                                                  reader.take(static_cast<int>(parameter));
      }
      if (reader.overrun()) return std::nullopt;
    }
  }
  if (!reader.at_end()) return std::nullopt;
  return values;
}

}  // namespace kerf::codec
