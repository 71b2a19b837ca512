// Tests frames with recorded bytes, in both encodings, and the state of a mirror after each. The viewer's decoder,
// which shares no code with this one, reads the same files: web/test/golden_frames.test.ts.
//   KERF_WRITE_GOLDEN=1 golden_frames_test     writes them again, after the format has changed on purpose

#include <bit>
#include <cstdint>
#include <cstdlib>
#include <fstream>
#include <iterator>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include <gtest/gtest.h>

#include "server/service/wire/frame_encoder.h"
#include "tests/support/paths.h"
#include "tests/wire/changing_sheet.h"
#include "tests/wire/frame_mirror.h"

namespace kerf::wire {
namespace {

using testing::ChangingSheet;
using testing::FrameMirror;

const std::filesystem::path kFolder = test::source_path("tests/data/frames");

// FNV-1a, 32 bits, over little-endian words.
class Fnv {
 public:
  void add(std::uint32_t word) {
    for (int shift = 0; shift < 32; shift += 8) hash_ = (hash_ ^ ((word >> shift) & 0xffU)) * 16777619U;
  }
  [[nodiscard]] std::uint32_t value() const { return hash_; }

 private:
  std::uint32_t hash_ = 2166136261U;
};

std::uint32_t hash_of(const FrameMirror& mirror) {
  Fnv hash;
  for (const std::int32_t q : mirror.quantised) hash.add(static_cast<std::uint32_t>(q));
  for (const auto& triangle : mirror.triangles) {
    for (const std::int32_t vertex : triangle) hash.add(static_cast<std::uint32_t>(vertex));
  }
  for (const std::int32_t piece : mirror.pieces) hash.add(static_cast<std::uint32_t>(piece));
  for (const float strain : mirror.strains) hash.add(std::bit_cast<std::uint32_t>(strain));
  for (const auto& position : mirror.material) {
    for (const float x : position) hash.add(std::bit_cast<std::uint32_t>(x));
  }
  return hash.value();
}

std::string message(std::int64_t sequence, const std::string& body, const std::string& rest) {
  return encode_frame_head(sequence, 0, {}, body.size() + rest.size()) + body + rest;
}

// Moves, cuts, a leap out of the box, a reset, ticks that are skipped.
std::vector<std::string> make_messages(Encoding encoding) {
  ChangingSheet sheet(2024, 90, 150);
  std::vector<std::string> messages;
  std::optional<QuantisedFrame> last;
  for (int tick = 0; tick < 40; ++tick) {
    sheet.move(0.003, tick == 25 ? 3.0 : 0.002);
    if (tick % 7 == 3) sheet.cut(4);
    if (tick == 30) sheet.reset(60, 100);
    if (tick % 11 == 8) continue;
    const QuantisedFrame frame =
        quantise_frame(*sheet.snapshot(tick % 3 == 1), last ? std::optional(last->box) : std::nullopt);
    const Predictors predictors = make_predictors(*frame.topology);
    const std::int32_t told = last ? last->topology->version : -1;
    EncodedTopology topology;
    if (told != frame.topology->version) {
      topology = encode_topology(*frame.topology, told, encoding == Encoding::kRaw ? nullptr : &predictors);
    }
    const bool is_delta = last && !topology.full && last->box == frame.box;
    const std::string body = encoding == Encoding::kRaw ? encode_raw_body(frame)
                             : is_delta                 ? encode_delta_body(frame, *last, predictors)
                                                        : encode_keyframe_body(frame, predictors);
    const std::string strains =
        frame.strains ? encode_strains(frame, encoding == Encoding::kRaw ? nullptr : &predictors) : std::string();
    messages.push_back(message(static_cast<std::int64_t>(messages.size()) + 1, body, topology.bytes + strains));
    last = frame;
  }
  return messages;
}

// Each message after its length as four little-endian bytes.
std::string file_of(const std::vector<std::string>& messages) {
  std::string file;
  for (const std::string& each : messages) {
    for (int shift = 0; shift < 32; shift += 8) file += static_cast<char>((each.size() >> shift) & 0xffU);
    file += each;
  }
  return file;
}

// One line a frame.
std::string hashes_of(const std::vector<std::string>& messages) {
  std::ostringstream lines;
  FrameMirror mirror;
  for (const std::string& each : messages) {
    v1::WatchResponse response;
    EXPECT_TRUE(response.ParseFromString(each));
    EXPECT_EQ(mirror.apply(response.frame()), std::nullopt);
    lines << std::hex << hash_of(mirror) << '\n';
  }
  return lines.str();
}

void expect_file(const std::string& name, const std::string& content) {
  const std::string path = kFolder / name;
  if (std::getenv("KERF_WRITE_GOLDEN") != nullptr) {
    std::ofstream(path, std::ios::binary) << content;
  }
  std::ifstream in(path, std::ios::binary);
  const std::string golden((std::istreambuf_iterator<char>(in)), std::istreambuf_iterator<char>());
  EXPECT_TRUE(golden == content) << path << " differs from what is encoded now";
}

TEST(GoldenFrames, CompactAndRawAreThoseWrittenDown) {
  const std::vector<std::string> compact = make_messages(Encoding::kCompact);
  const std::vector<std::string> raw = make_messages(Encoding::kRaw);
  const std::string hashes = hashes_of(compact);
  EXPECT_EQ(hashes, hashes_of(raw)) << "the encodings show different sheets";
  expect_file("compact.bin", file_of(compact));
  expect_file("raw.bin", file_of(raw));
  expect_file("hashes.txt", hashes);
}

}  // namespace
}  // namespace kerf::wire
