#include "server/service/wire/self_contact_codec.h"

#include <array>
#include <utility>

#include "server/service/wire/choices.h"

namespace kerf::wire {
namespace {

constexpr std::array<std::pair<v1::SelfContact::Mode, bool>, 2> kSelfContactModes{{
    {v1::SelfContact::ON, true},
    {v1::SelfContact::OFF, false},
}};

}  // namespace

Result<scene::SelfContact> decode_self_contact(const v1::SelfContact& message) {
  scene::SelfContact self_contact;
  KERF_TRY(decode_choice(kSelfContactModes, message.mode(), "self_contact.mode", self_contact.is_on));
  if (message.has_friction()) self_contact.friction = message.friction();
  if (message.has_thickness_m()) self_contact.thickness = message.thickness_m();
  return self_contact;
}

v1::SelfContact encode_self_contact(const scene::SelfContact& self_contact) {
  v1::SelfContact message;
  message.set_mode(encode_choice(kSelfContactModes, self_contact.is_on));
  message.set_friction(self_contact.friction);
  if (self_contact.thickness) message.set_thickness_m(*self_contact.thickness);
  return message;
}

Result<scene::SetSelfContact> decode_self_contact_change(const v1::SetSelfContact& message) {
  scene::SetSelfContact change;
  KERF_TRY(decode_choice(kSelfContactModes, message.mode(), "set_self_contact.mode", change.is_on));
  if (message.has_friction()) change.friction = message.friction();
  if (message.has_thickness_m()) change.thickness = message.thickness_m();
  change.material_thickness = message.material_thickness();
  return change;
}

v1::SetSelfContact encode_self_contact_change(const scene::SetSelfContact& change) {
  v1::SetSelfContact message;
  if (change.is_on) message.set_mode(encode_choice(kSelfContactModes, *change.is_on));
  if (change.friction) message.set_friction(*change.friction);
  if (change.thickness) message.set_thickness_m(*change.thickness);
  message.set_material_thickness(change.material_thickness);
  return message;
}

v1::SelfContactCounts encode_self_contact_counts(const fem::SelfContactStats& stats) {
  v1::SelfContactCounts message;
  message.set_phases(stats.phases);
  message.set_searches(stats.searches);
  message.set_contacts(stats.contacts);
  message.set_repairs(stats.repairs);
  message.set_zones(stats.zones);
  message.set_unsettled(stats.unsettled);
  message.set_intersections(stats.intersections);
  return message;
}

}  // namespace kerf::wire
