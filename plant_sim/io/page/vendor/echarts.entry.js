// SPDX-License-Identifier: Apache-2.0
// The parts of Apache ECharts that the reports draw with. What is not named here is not in echarts.min.js.
export { init, getInstanceByDom } from "echarts/core";
import { use } from "echarts/core";
import { CustomChart, LineChart, SankeyChart } from "echarts/charts";
import {
  DataZoomInsideComponent,
  GridComponent,
  MarkLineComponent,
  MarkPointComponent,
  TooltipComponent,
} from "echarts/components";
import { CanvasRenderer } from "echarts/renderers";

use([
  CustomChart, LineChart, SankeyChart,
  DataZoomInsideComponent, GridComponent, MarkLineComponent, MarkPointComponent, TooltipComponent,
  CanvasRenderer,
]);
