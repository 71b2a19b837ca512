#pragma once

#include <cstdint>
#include <string>
#include <string_view>

#include "kerf/v1/cuts.pb.h"
#include "kerf/v1/run.pb.h"
#include "server/sheet/command.h"
#include "server/sheet/sheet.h"

// What a sheet answers, as messages.
namespace kerf::wire {

// 16 hex digits.
std::string encode_hash(std::uint64_t hash);

// The outcome of a Cut (reply.cut must be there) without `name` and timings, which the owner of the sheet knows.
v1::CutResult encode_cut_result(const sheet::CommandReply& reply);

v1::Energies encode_energies(const sheet::Energies& energies);

}  // namespace kerf::wire
