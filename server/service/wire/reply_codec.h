#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/run.pb.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/sheet.h"

// What a sheet answers, as messages.
namespace kerf::wire {

// 16 hex digits.
std::string encode_hash(std::uint64_t hash);

// The outcome of a cut, `cut` being part of the reply, without `name` and timings, which the owner of the sheet knows.
v1::CutResult encode_cut_result(const sheet::CommandReply& reply, const sheet::CutReply& cut);
// Of a Cut one, of a CutBatch one a cut, of other commands none.
std::vector<v1::CutResult> encode_cut_results(const sheet::CommandReply& reply);

v1::Piece encode_piece(const sheet::Piece& piece);

v1::Energies encode_energies(const sheet::Energies& energies);

// By the flags' names, those that were reported at all.
void encode_flags(const fem::FlagCounts& counts, google::protobuf::Map<std::string, std::int64_t>& message);

}  // namespace kerf::wire
