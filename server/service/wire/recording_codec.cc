#include "server/service/wire/recording_codec.h"

#include <google/protobuf/io/coded_stream.h>
#include <google/protobuf/wire_format_lite.h>

#include <algorithm>
#include <limits>
#include <optional>
#include <utility>
#include <variant>

#include "kerf/v1/run.pb.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/mesh_source_codec.h"
#include "server/service/wire/recording_frames.h"
#include "server/service/wire/scene_codec.h"

namespace kerf::wire {
namespace {

constexpr std::string_view kMagic = "kerf-recording";
constexpr std::int32_t kLastPlainFormat = 2;          // The last format without checksums.
constexpr std::int32_t kLastFormatOfFirstChoice = 3;  // The last format whose automatic integrator is the first.

using google::protobuf::internal::WireFormatLite;
using google::protobuf::io::CodedInputStream;

// Calls `visit` with the number and the bytes of each length-delimited field of a message, up to the first malformed
// one.
template <typename Visit>
void for_each_field(std::string_view message, Visit visit) {
  CodedInputStream in(reinterpret_cast<const std::uint8_t*>(message.data()), static_cast<int>(message.size()));
  while (const std::uint32_t tag = in.ReadTag()) {
    std::uint32_t length = 0;
    if (WireFormatLite::GetTagWireType(tag) != WireFormatLite::WIRETYPE_LENGTH_DELIMITED) {
      if (!WireFormatLite::SkipField(&in, tag)) return;
      continue;
    }
    if (!in.ReadVarint32(&length)) return;
    const auto at = static_cast<std::size_t>(in.CurrentPosition());
    if (length > message.size() - at || !in.Skip(static_cast<int>(length))) return;
    visit(WireFormatLite::GetTagFieldNumber(tag), message.substr(at, length));
  }
}

// Counts the bytes of a header without the text or numbers of its mesh, which do not grow when they are decoded.
std::size_t bytes_beside_mesh(std::string_view header) {
  std::size_t beside = header.size();
  const auto visit_mesh = [&beside](int, std::string_view content) { beside -= content.size(); };
  const auto visit_scene = [&](int field, std::string_view mesh) {
    if (field == v1::Scene::kObjFieldNumber || field == v1::Scene::kPlyFieldNumber ||
        field == v1::Scene::kInlineFieldNumber) {
      for_each_field(mesh, visit_mesh);
    }
  };
  for_each_field(header, [&](int field, std::string_view scene) {
    if (field == v1::RecordingHeader::kSceneFieldNumber) for_each_field(scene, visit_scene);
  });
  return beside;
}

// Counts parts as RecordingLimits does.
std::int64_t parts_of(const scene::Command& command) {
  if (const auto* cut = std::get_if<scene::Cut>(&command)) return num_parts(*cut);
  std::int64_t parts = 1;
  if (const auto* batch = std::get_if<scene::CutBatch>(&command)) {
    for (const scene::Cut& cut : batch->cuts) parts += num_parts(cut);
  }
  if (const auto* set_pins = std::get_if<scene::SetPins>(&command)) {
    parts += static_cast<std::int64_t>(set_pins->pins.size());
  }
  return parts;
}

// True if the command has a drawing. Recordings hold paths only, and a short drawing may unfold into a very long path.
bool has_drawing(const v1::Command& command) {
  const auto is_drawn = [](const v1::Cut& cut) { return cut.curve().has_svg() || cut.curve().has_dxf(); };
  const auto& batch = command.cut_batch().cuts();
  return is_drawn(command.cut()) || std::any_of(batch.begin(), batch.end(), is_drawn);
}

Result<sheet::RecordedTick> decode_tick(const v1::RecordedTick& message, std::size_t offset) {
  sheet::RecordedTick tick;
  tick.tick = message.tick();
  tick.state_hash = message.state_hash();
  for (int i = 0; i < message.commands_size(); ++i) {
    if (has_drawing(message.commands(i))) {
      return recording_damage(
          "RECORDING_DAMAGED", offset,
          "command " + std::to_string(i) + " holds a drawing; a recording must hold the path made from it");
    }
    Result<scene::Command> command = decode_command(message.commands(i));
    if (!command.ok()) {
      return recording_damage("RECORDING_DAMAGED", offset,
                              "command " + std::to_string(i) + " is refused: " + command.error().message);
    }
    tick.commands.push_back(std::move(*command));
  }
  return tick;
}

// Reads the ticks of a file, one after another.
class TickReader {
 public:
  TickReader(RecordingReader& reader, const RecordingLimits& limits) : reader_(reader), limits_(limits) {}

  // Appends the next tick. Returns false if the file ends within it.
  Result<bool> read_into(std::vector<sheet::RecordedTick>& entries) {
    KERF_TRY_ASSIGN(const std::optional<std::string_view> bytes, reader_.next());
    if (!bytes) return false;
    KERF_TRY_ASSIGN(sheet::RecordedTick tick, decode(*bytes));
    KERF_TRY(check(tick, entries));
    entries.push_back(std::move(tick));
    return true;
  }

 private:
  Result<sheet::RecordedTick> decode(std::string_view bytes) const {
    v1::RecordedTick message;
    KERF_TRY(reader_.parse(bytes, bytes.size(), message));
    return decode_tick(message, reader_.offset());
  }

  Status check(const sheet::RecordedTick& tick, const std::vector<sheet::RecordedTick>& entries) {
    const std::int64_t before = entries.empty() ? 0 : entries.back().tick;
    if (const Status s = sheet::check_next(tick, entries.size(), before); !s.ok()) {
      return recording_damage(s.error().reason.c_str(), reader_.offset(), s.error().message);
    }
    if (static_cast<std::int64_t>(entries.size()) == limits_.max_entries) {
      return recording_too_large(reader_.offset(), "there are more ticks than allowed", limits_.max_entries);
    }
    for (const scene::Command& command : tick.commands) parts_ += parts_of(command);
    if (parts_ > limits_.max_parts) {
      return recording_too_large(reader_.offset(), "there are more commands, or larger ones, than allowed",
                                 limits_.max_parts);
    }
    return Nothing{};
  }

  RecordingReader& reader_;
  const RecordingLimits& limits_;
  std::int64_t parts_ = 0;
};

Error no_recording() {
  return recording_damage("RECORDING_FORMAT", 0, "this is not a Kerf recording");
}

Status check_format(std::int32_t version, bool is_checked) {
  if (version < 1 || version > kRecordingFormat) {
    return recording_damage("RECORDING_FORMAT", 0,
                            "format version " + std::to_string(version) + "; this program reads versions 1 to " +
                                std::to_string(kRecordingFormat));
  }
  if (is_checked == (version > kLastPlainFormat)) return Nothing{};
  return recording_damage("RECORDING_FORMAT", 0,
                          "a file of format version " + std::to_string(version) + " begins with different bytes");
}

Result<v1::RecordingHeader> read_header(RecordingReader& reader) {
  const Result<std::optional<std::string_view>> bytes = reader.next();
  if (!bytes.ok()) return reader.is_checked() ? bytes.error() : no_recording();
  if (!*bytes) return recording_damage("RECORDING_TRUNCATED", reader.offset(), "the file ends within its header");
  v1::RecordingHeader header;
  const Status parsed = reader.parse(**bytes, bytes_beside_mesh(**bytes), header);
  if (!parsed.ok() && parsed.error().reason == "RECORDING_TOO_LARGE") return parsed.error();
  if (!parsed.ok() || header.magic() != kMagic) return no_recording();
  KERF_TRY(check_format(header.format_version(), reader.is_checked()));
  return header;
}

}  // namespace

std::string build_name() {
#ifdef __OPTIMIZE__
  return std::string("g++ ") + __VERSION__ + ", optimised";
#else
  return std::string("g++ ") + __VERSION__ + ", not optimised";
#endif
}

std::string encode_recording_header(const scene::SheetConfig& config, std::string_view build) {
  v1::RecordingHeader header;
  header.set_magic(std::string(kMagic));
  const bool is_first_choice = config.integrator.choice == scene::kFirstChoice;
  header.set_format_version(is_first_choice ? kLastFormatOfFirstChoice : kRecordingFormat);
  header.set_build(std::string(build));
  *header.mutable_scene() = encode_scene(config);
  return std::string(kRecordingSignature) + recording_frame(header);
}

std::string encode_recorded_tick(const sheet::RecordedTick& tick) {
  v1::RecordedTick message;
  message.set_tick(tick.tick);
  message.set_state_hash(tick.state_hash);
  for (const scene::Command& command : tick.commands) *message.add_commands() = encode_command(command);
  return recording_frame(message);
}

Result<RecordingFile> decode_recording(std::string_view file, const RecordingLimits& limits) {
  KERF_TRY_ASSIGN(RecordingReader reader, RecordingReader::open(file));
  KERF_TRY_ASSIGN(v1::RecordingHeader header, read_header(reader));
  RecordingFile decoded;
  decoded.build = header.build();
  name_first_reader(*header.mutable_scene());
  Result<scene::SheetConfig> config = decode_scene(std::move(*header.mutable_scene()));
  if (!config.ok()) return recording_damage("RECORDING_DAMAGED", 0, "the scene is refused: " + config.error().message);
  decoded.recording.config = std::move(*config);
  if (header.format_version() <= kLastFormatOfFirstChoice) {
    decoded.recording.config.integrator.choice = scene::kFirstChoice;
  }
  TickReader ticks(reader, limits);
  while (!reader.done() && decoded.recording.torn_bytes == 0) {
    KERF_TRY_ASSIGN(const bool whole, ticks.read_into(decoded.recording.entries));
    if (!whole) decoded.recording.torn_bytes = static_cast<std::int64_t>(reader.bytes_from_offset());
  }
  return decoded;
}

}  // namespace kerf::wire
