#pragma once

#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/service/wire/geometry_codec.h"

// Converts kerf.v1.Command to and from scene::Command. Errors as in scene_codec.h, with field paths that begin at the
// command ("cut.curve.bezier", "grab.target.x"). Decoding a Reset, an UndoCut or a RedoCut has no errors.
namespace kerf::wire {

// `read_file`: for Svg.file; see geometry_codec.h.
Result<scene::Command> decode_command(const v1::Command& command, const FileReader& read_file = {});
v1::Command encode_command(const scene::Command& command);
v1::Cut encode_cut(const scene::Cut& cut);

// Limit on the parts of one batch (see num_parts()), because a short drawing may unfold to very many segments.
inline constexpr std::int64_t kMaxBatchParts = 131'072;
// Counts the cut, and the subpaths and segments of its path.
std::int64_t num_parts(const scene::Cut& cut);
// Decodes a CutBatch; paths begin with "cut_batch.cuts[0]". BATCH_TOO_LONG: more than kMaxBatchParts.
Result<scene::Command> decode_cuts(const google::protobuf::RepeatedPtrField<v1::Cut>& cuts,
                                   const FileReader& read_file = {});

// Decode one kind of command, with the same paths: requests carry these messages in fields of the same names.
Result<scene::Command> decode_cut(const v1::Cut& cut, const FileReader& read_file = {});
Result<scene::Command> decode_grab(const v1::Grab& grab);
Result<scene::Command> decode_drag(const v1::Drag& drag);
Result<scene::Command> decode_release(const v1::Release& release);
Result<scene::Command> decode_set_pins(const v1::SetPins& set_pins);
Result<scene::Command> decode_set_gravity(const v1::SetGravity& set_gravity);
Result<scene::Command> decode_set_wind(const v1::SetWind& set_wind);
Result<scene::Command> decode_set_material(const v1::SetMaterial& set_material);
Result<scene::Command> decode_set_self_contact(const v1::SetSelfContact& set_self_contact);

}  // namespace kerf::wire
