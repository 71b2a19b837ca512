#pragma once

#include "kerf/v1/run.pb.h"
#include "kerf/v1/scene.pb.h"
#include "server/base/result.h"
#include "server/core/scene/command.h"
#include "server/core/sheet/sheet.h"

// Converts kerf.v1.SelfContact, SetSelfContact and SelfContactCounts. Decoding does not check ranges, except those of
// enumerators.
namespace kerf::wire {

Result<scene::SelfContact> decode_self_contact(const v1::SelfContact& message);
v1::SelfContact encode_self_contact(const scene::SelfContact& self_contact);

Result<scene::SetSelfContact> decode_self_contact_change(const v1::SetSelfContact& message);
v1::SetSelfContact encode_self_contact_change(const scene::SetSelfContact& change);

v1::SelfContactCounts encode_self_contact_counts(const fem::SelfContactStats& stats);

}  // namespace kerf::wire
