#include "vdbcloud/solve/graph.h"

#include "vdbcloud/solve/parallel.h"

#include <algorithm>

namespace vdbcloud {

double Graph::linked(size_t i) const
{
    double sum = 0;
    for (uint32_t k = begin[i]; k < begin[i + 1]; ++k) sum += c[k];
    return sum;
}

void Graph::add_row(std::vector<std::pair<int32_t, float>>& links, double extra_of_row)
{
    std::sort(links.begin(), links.end());
    for (size_t k = 0; k < links.size();) {
        const int32_t to = links[k].first;
        double sum = 0;
        for (; k < links.size() && links[k].first == to; ++k) sum += links[k].second;
        column.push_back(to);
        c.push_back(float(sum));
    }
    links.clear();
    begin.push_back(uint32_t(column.size()));
    extra.push_back(float(extra_of_row));
}

void Graph::append(const Graph& rows)
{
    const uint32_t before = uint32_t(column.size());
    column.insert(column.end(), rows.column.begin(), rows.column.end());
    c.insert(c.end(), rows.c.begin(), rows.c.end());
    extra.insert(extra.end(), rows.extra.begin(), rows.extra.end());
    for (size_t i = 1; i < rows.begin.size(); ++i) begin.push_back(before + rows.begin[i]);
}

void list_members(const std::vector<int32_t>& group, size_t count, std::vector<uint32_t>& first,
                  std::vector<int32_t>& member)
{
    first.assign(count + 1, 0);
    for (int32_t g : group)
        if (g >= 0) ++first[size_t(g) + 1];
    for (size_t g = 0; g < count; ++g) first[g + 1] += first[g];
    member.resize(first[count]);
    std::vector<uint32_t> at(first.begin(), first.end() - 1);
    for (size_t i = 0; i < group.size(); ++i)
        if (group[i] >= 0) member[at[size_t(group[i])]++] = int32_t(i);
}

Graph collapsed(const Graph& fine, const std::vector<int32_t>& group, size_t count)
{
    std::vector<uint32_t> first;
    std::vector<int32_t> member;
    list_members(group, count, first, member);
    constexpr size_t part_size = 4096;
    std::vector<Graph> parts((count + part_size - 1) / part_size);
    for_each(parts.size(), [&](size_t part) {
        std::vector<std::pair<int32_t, float>> links;
        for (size_t g = part * part_size; g < std::min(count, (part + 1) * part_size); ++g) {
            double extra = 0;
            for (uint32_t m = first[g]; m < first[g + 1]; ++m) {
                const size_t i = size_t(member[m]);
                extra += fine.extra[i];
                for (uint32_t k = fine.begin[i]; k < fine.begin[i + 1]; ++k) {
                    const int32_t to = group[size_t(fine.column[k])];
                    if (to < 0)
                        extra += fine.c[k];
                    else if (size_t(to) != g)
                        links.emplace_back(to, fine.c[k]);
                }
            }
            parts[part].add_row(links, extra);
        }
    });
    if (parts.size() == 1) return std::move(parts[0]);
    Graph coarse;
    for (Graph& part : parts) {
        coarse.append(part);
        part = {};
    }
    return coarse;
}

}  // namespace vdbcloud
