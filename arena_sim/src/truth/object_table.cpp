#include "truth/object_table.h"

#include <fmt/format.h>

namespace rubble::arena_sim {

std::string objectTable(const World& world) {
  std::string table = "id,class,kind,text,x,y,z,qw,qx,qy,qz,width,height\n";
  for (const WorldObject& object : world.objects) {
    const Eigen::Vector3d p = object.T_world_object.translation();
    const Eigen::Quaterniond q(object.T_world_object.linear());
    table += fmt::format("{},{},{},\"{}\",{:.4f},{:.4f},{:.4f},{:.6f},{:.6f},{:.6f},{:.6f},{:.4f},{:.4f}\n",
                         object.id, object.object_class, object.kind, object.text, p.x(), p.y(), p.z(), q.w(),
                         q.x(), q.y(), q.z(), object.size.x(), object.size.y());
  }
  return table;
}

}  // namespace rubble::arena_sim
