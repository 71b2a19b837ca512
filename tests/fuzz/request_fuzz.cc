// Bytes -> kerf.v1.CreateCutRequest, binary or JSON -> command -> sheet. Whatever the bytes, the answer is a value, and
// the sheet is sound; what is refused leaves its mesh as it was.
#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string_view>

#include "kerf/v1/cuts.pb.h"
#include "server/base/check.h"
#include "server/core/sheet/sheet.h"
#include "server/service/wire/command_codec.h"
#include "server/service/wire/json.h"
#include "tests/audit/mesh_audit.h"
#include "tests/support/scenes.h"

namespace {

using namespace kerf;

constexpr std::int32_t kVertices = 6;              // a side
constexpr std::int32_t kMostNewTriangles = 4'000;  // so that no input takes long

std::optional<scene::Command> decode(std::string_view text, bool is_json) {
  v1::CreateCutRequest request;
  if (is_json) {
    if (!wire::from_json(text, request).ok()) return std::nullopt;
  } else if (!request.ParseFromArray(text.data(), static_cast<int>(text.size()))) {
    return std::nullopt;
  }
  const Result<scene::Command> command = wire::decode_cut(request.cut());
  if (!command.ok()) {
    KERF_CHECK(!command.error().reason.empty() && !command.error().message.empty(), "a refusal says why");
    return std::nullopt;
  }
  // A decoded request is encoded to one that decodes the same way.
  const v1::Command encoded = wire::encode_command(*command);
  KERF_CHECK(wire::decode_command(encoded).ok(), "an accepted command is accepted again");
  return *command;
}

}  // namespace

extern "C" int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
  if (size == 0) return 0;
  std::optional<scene::Command> command = decode({reinterpret_cast<const char*>(data + 1), size - 1}, data[0] == '{');
  if (!command) return 0;
  auto& cut = std::get<scene::Cut>(*command);
  cut.options.max_new_triangles = std::min(cut.options.max_new_triangles, kMostNewTriangles);
  static const scene::SheetConfig config = scenes::hanging(kVertices);
  Result<sheet::Sheet> made = sheet::Sheet::create(config);
  KERF_CHECK(made.ok(), "the scene is good");
  const std::uint64_t before = made->mesh().state_hash();
  const std::array<scene::Command, 1> commands{*command};
  made->apply(commands);
  if (made->topology_version() == 0) KERF_CHECK(made->mesh().state_hash() == before, "nothing was cut");
  if (const audit::Finding flaw = audit::find_flaw(made->mesh())) KERF_CHECK(false, flaw->c_str());
  return 0;
}
