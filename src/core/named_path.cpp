// SPDX-License-Identifier: BSD-3-Clause
#include "core/named_path.hpp"

#include "core/error.hpp"

namespace culm::core {

std::string named_path_fault(std::string_view name) {
    const std::filesystem::path path(name);
    if (name.empty())
        return "must be the name of a file";
    if (name.find('\0') != std::string_view::npos)
        return "must not hold a zero byte";
    const std::filesystem::path plain = path.lexically_normal();
    if (path.is_absolute() || (!plain.empty() && *plain.begin() == ".."))
        return "must lie in the folder of the file that names it, or below (a symbolic link there "
               "may lead elsewhere)";
    return "";
}

std::filesystem::path path_named_in(const std::filesystem::path& file, const std::string& name) {
    if (const std::string fault = named_path_fault(name); !fault.empty())
        throw InputError("\"" + name + "\" " + fault);
    return file.parent_path() / name;
}

} // namespace culm::core
