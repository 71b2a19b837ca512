// proto/README.md specifies the stream for clients in other languages. Its field numbers are compared with the proto
// files. Its two frames are compared with those that the encoder writes, byte by byte and number by number.

#include <algorithm>
#include <array>
#include <cstddef>
#include <cstdint>
#include <cstdio>
#include <cstring>
#include <fstream>
#include <iterator>
#include <map>
#include <memory>
#include <optional>
#include <regex>
#include <sstream>
#include <string>
#include <string_view>
#include <vector>

#include <google/protobuf/descriptor.h>
#include <gtest/gtest.h>

#include "kerf/v1/stream.pb.h"
#include "server/service/codec/position_code.h"
#include "server/service/codec/topology_code.h"
#include "server/service/wire/frame_encoder.h"
#include "tests/support/paths.h"

namespace kerf::wire {
namespace {

using google::protobuf::Descriptor;
using google::protobuf::FieldDescriptor;

std::string read_page() {
  std::ifstream in(test::source_path("proto/README.md"));
  return {std::istreambuf_iterator<char>(in), {}};
}

// Four vertices and two triangles on 1 m; vertices 2 and 3 have fallen by `fall_m`.
std::shared_ptr<const sheet::Snapshot> small_sheet(std::int64_t tick, double fall_m,
                                                   const std::shared_ptr<const sheet::Topology>& topology) {
  auto snapshot = std::make_shared<sheet::Snapshot>();
  snapshot->tick = tick;
  snapshot->topology = topology;
  snapshot->positions.resize(3, 4);
  snapshot->positions << 0.0, 1.0, 0.0, 1.0,  //
      0.0, 0.0, 1.0, 1.0,                     //
      0.0, 0.0, -fall_m, -fall_m;
  return snapshot;
}

std::shared_ptr<const sheet::Topology> small_topology() {
  auto topology = std::make_shared<sheet::Topology>();
  topology->num_triangles = 2;
  topology->num_pieces = 1;
  topology->triangles = {{0, 1, 2}, {1, 3, 2}};
  topology->pieces = {0, 0};
  topology->slot_versions = {1, 1};
  topology->material_positions.resize(2, 4);
  topology->material_positions << 0.0, 1.0, 0.0, 1.0,  //
      0.0, 0.0, 1.0, 1.0;
  topology->vertex_versions = {1, 1, 1, 1};
  return topology;
}

// Rows of `columns` numbers: "0 1 2, 1 3 2".
template <typename Numbers>
std::string rows(const Numbers& numbers, std::size_t columns) {
  std::ostringstream text;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    text << (i == 0 ? "" : i % columns == 0 ? ", " : " ") << numbers[i];
  }
  return text.str();
}

std::string rows(const std::vector<std::array<std::int32_t, 3>>& triangles) {
  std::vector<std::int32_t> numbers;
  for (const auto& triangle : triangles) numbers.insert(numbers.end(), triangle.begin(), triangle.end());
  return rows(numbers, 3);
}

// A serialised WatchResponse, a line a field: its name and number, then its bytes.
class Dump {
 public:
  // `arrays`: numbers of packed fields, by name.
  Dump(std::string_view bytes, std::map<std::string, std::string> arrays) : bytes_(bytes), arrays_(std::move(arrays)) {
    message(*v1::WatchResponse::descriptor(), bytes_.size(), 0);
  }
  [[nodiscard]] std::string text() const { return lines_.str(); }

 private:
  std::uint64_t varint() {
    std::uint64_t value = 0;
    for (int shift = 0;; shift += 7) {
      const auto byte = static_cast<unsigned char>(bytes_.at(at_++));
      value |= std::uint64_t{byte & 0x7fU} << shift;
      if (byte < 0x80) return value;
    }
  }
  // The bytes from `begin` to here, long ones on lines of their own.
  void line(int depth, const std::string& name, std::size_t begin) {
    constexpr std::size_t kBytesALine = 20;
    const std::string indent(2 * static_cast<std::size_t>(depth), ' ');
    lines_ << indent << name << ':';
    for (std::size_t i = begin; i < at_; ++i) {
      if (at_ - begin > kBytesALine && (i - begin) % kBytesALine == 0) lines_ << '\n' << indent << "   ";
      std::array<char, 4> hex{};
      std::snprintf(hex.data(), hex.size(), " %02x", static_cast<unsigned>(static_cast<unsigned char>(bytes_[i])));
      lines_ << hex.data();
    }
    lines_ << '\n';
  }
  void message(const Descriptor& type, std::size_t end, int depth) {
    while (at_ < end) field(type, depth);
    EXPECT_EQ(at_, end);
  }
  void field(const Descriptor& type, int depth) {
    const std::size_t begin = at_;
    const std::uint64_t key = varint();
    const FieldDescriptor* const field = type.FindFieldByNumber(static_cast<int>(key >> 3));
    ASSERT_NE(field, nullptr) << type.full_name() << " has no field " << (key >> 3);
    const std::string& name = field->name();
    if ((key & 7U) == 0) {
      const auto value = static_cast<std::int64_t>(varint());
      const bool names_it = field->type() == FieldDescriptor::TYPE_ENUM;
      const std::string number =
          names_it ? field->enum_type()->FindValueByNumber(static_cast<int>(value))->name() : std::to_string(value);
      return line(depth, name + ' ' + number, begin);
    }
    if ((key & 7U) == 1) {
      double value = 0.0;
      std::memcpy(&value, bytes_.substr(at_).data(), sizeof(value));
      at_ += sizeof(value);
      std::ostringstream number;
      number << name << ' ' << value;
      return line(depth, number.str(), begin);
    }
    ASSERT_EQ(key & 7U, 2U);
    const std::size_t size = varint();
    if (field->type() == FieldDescriptor::TYPE_MESSAGE) {
      line(depth, name + ", " + std::to_string(size) + " bytes", begin);
      return message(*field->message_type(), at_ + size, depth + 1);
    }
    at_ += size;
    const auto numbers = arrays_.find(name);
    const std::string content(bytes_.substr(at_ - size, size));
    line(depth, name + ' ' + (numbers == arrays_.end() ? '"' + content + '"' : '(' + numbers->second + ')'), begin);
  }

  const std::string_view bytes_;
  const std::map<std::string, std::string> arrays_;
  std::size_t at_ = 0;
  std::ostringstream lines_;
};

// The numbers of a frame's arrays. `base`: positions that a delta is to.
std::map<std::string, std::string> arrays_of(const v1::Frame& frame, const Predictors& predictors,
                                             const std::vector<std::uint16_t>& base) {
  const auto positions = codec::unpack_position_delta(frame.positions(), base, predictors);
  std::map<std::string, std::string> arrays{{"positions", rows(positions.value(), 3)}};
  if (!frame.has_topology()) return arrays;
  const v1::TopologyPatch& patch = frame.topology();
  const auto num_slots = static_cast<std::size_t>(patch.num_listed_slots());
  std::vector<float> material(2 * predictors.size());
  EXPECT_TRUE(codec::unpack_material_positions(patch.material_positions(), std::vector<std::uint32_t>{0, 1, 2, 3},
                                               predictors, material));
  arrays["triangles"] = rows(codec::unpack_triangles(patch.triangles(), num_slots, true).value());
  arrays["pieces"] = rows(codec::unpack_labels(patch.pieces(), num_slots).value(), 1);
  arrays["material_positions"] = rows(material, 2);
  return arrays;
}

std::string dump(const std::string& bytes, const Predictors& predictors, const std::vector<std::uint16_t>& base) {
  v1::WatchResponse response;
  EXPECT_TRUE(response.ParseFromString(bytes));
  return Dump(bytes, arrays_of(response.frame(), predictors, base)).text();
}

TEST(StreamPage, FramesAreThoseThatTheEncoderWrites) {
  const auto topology = small_topology();
  const Predictors predictors = make_predictors(*topology);
  const QuantisedFrame first = quantise_frame(*small_sheet(60, 0.0, topology), std::nullopt);
  const QuantisedFrame second = quantise_frame(*small_sheet(61, 0.01, topology), first.box);
  const std::string keyframe =
      encode_keyframe_body(first, predictors) + encode_topology(*topology, -1, &predictors).bytes;
  const std::string delta = encode_delta_body(second, first, predictors);
  const std::string block = dump(encode_frame_head(1, 0, "3f-1", keyframe.size()) + keyframe, predictors, {}) + '\n' +
                            dump(encode_frame_head(2, 0, "", delta.size()) + delta, predictors, first.positions);
  EXPECT_NE(read_page().find("```text\n" + block + "```\n"), std::string::npos) << "the page should have\n" << block;
}

// A row such as "| `WatchAck` | `sequence` 1, `held_us` 2 |" has all fields of the message.
TEST(StreamPage, FieldNumbersAreThoseOfTheProto) {
  const std::string page = read_page();
  const std::regex row(R"(\n\| `(\w+)` \| (.*) \|)");
  const std::regex entry(R"(`(\w+)` (\d+))");
  const google::protobuf::DescriptorPool& pool = *v1::Frame::descriptor()->file()->pool();
  int num_messages = 0;
  for (std::sregex_iterator each(page.begin(), page.end(), row), end; each != end; ++each) {
    const Descriptor* const type = pool.FindMessageTypeByName("kerf.v1." + (*each)[1].str());
    if (type == nullptr) continue;
    ++num_messages;
    const std::string fields = (*each)[2];
    std::vector<std::string> listed;
    for (std::sregex_iterator one(fields.begin(), fields.end(), entry); one != end; ++one) {
      const FieldDescriptor* const field = type->FindFieldByName((*one)[1]);
      ASSERT_NE(field, nullptr) << type->name() << '.' << (*one)[1];
      EXPECT_EQ(std::to_string(field->number()), (*one)[2]) << field->full_name();
      listed.push_back((*one)[1]);
    }
    for (int i = 0; i < type->field_count(); ++i) {
      EXPECT_EQ(std::ranges::count(listed, type->field(i)->name()), 1) << type->field(i)->full_name();
    }
  }
  EXPECT_EQ(num_messages, 11);
}

}  // namespace
}  // namespace kerf::wire
