#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/run.pb.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/sheet.h"

// Encodes a sheet's replies as messages.
namespace kerf::wire {

// Returns 16 hex digits.
std::string encode_hash(std::uint64_t hash);

// Encodes the outcome of `cut`, a part of `reply`. The caller, which knows the sheet, adds `name` and timings.
v1::CutResult encode_cut_result(const scene::CommandReply& reply, const scene::CutReply& cut);
// Returns one result for a Cut, one per cut for a CutBatch, none for other commands.
std::vector<v1::CutResult> encode_cut_results(const scene::CommandReply& reply);

v1::Piece encode_piece(const scene::Piece& piece);

v1::Energies encode_energies(const sheet::Energies& energies);

// Encodes the counts by the flags' names; flags never reported are left out.
void encode_flags(const fem::FlagCounts& counts, google::protobuf::Map<std::string, std::int64_t>& message);

}  // namespace kerf::wire
