// The whole way that a map in the making was drawn from: thin, below the trail of the last minute.

export function drawWay(context, view, palette, poses) {
  const [count] = poses.shape;
  if (count < 2) return;
  context.beginPath();
  for (let i = 0; i < count; i++) {
    const { x, y } = view.toScreen({ x: poses.data[3 * i], y: poses.data[3 * i + 1] });
    if (i) context.lineTo(x, y);
    else context.moveTo(x, y);
  }
  context.lineJoin = context.lineCap = "round";
  context.strokeStyle = palette.trail;
  context.globalAlpha = 0.6;
  context.lineWidth = 1.5;
  context.stroke();
  context.globalAlpha = 1;
}
