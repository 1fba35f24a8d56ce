#pragma once

#include <string>
#include <vector>

#include "data/tool_setup.h"

namespace sinew {

/// OpenSim documents of version 40000 that read_ik_task_set, read_ik_setup and read_id_setup read.
/// Paths are written as they stand: relative ones are resolved against the document's folder.

/// Tasks with their weights; coordinates go to their default, or with ValueType::kFromFile to the
/// setup's coordinate file.
std::string ik_tasks_document(const std::string& name, const std::vector<IkTask>& tasks);

/// Names tasks in a file of their own.
std::string ik_setup_document(const IkSetup& setup);

std::string id_setup_document(const IdSetup& setup);

}  // namespace sinew
