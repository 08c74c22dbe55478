#include "server/call/chunk/wire_part.h"

#include "server/call/invalid_option.h"

namespace curvd {

absl::Status ReadPart(const curvature::v1::CloudPart& proto, CloudPart& part) {
  part = {proto.has_ids(), proto.has_roles(), std::nullopt};
  if (!proto.has_lattice()) return absl::OkStatus();
  const curvature::v1::Vector3& origin = proto.lattice().origin();
  part.lattice = Lattice{proto.lattice().spacing(), {origin.x(), origin.y(), origin.z()}};
  absl::Status status = part.lattice->Validate();
  return status.ok() ? status : InvalidOptionAt("header.part.", status);
}

void WritePart(const CloudPart& part, curvature::v1::CloudPart& proto) {
  proto.set_has_ids(part.has_ids);
  proto.set_has_roles(part.has_roles);
  if (!part.lattice.has_value()) return;
  proto.mutable_lattice()->set_spacing(part.lattice->spacing);
  curvature::v1::Vector3& origin = *proto.mutable_lattice()->mutable_origin();
  origin.set_x(part.lattice->origin[0]);
  origin.set_y(part.lattice->origin[1]);
  origin.set_z(part.lattice->origin[2]);
}

}  // namespace curvd
