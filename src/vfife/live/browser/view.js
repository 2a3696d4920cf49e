// State of the view. shell.js passes it to the next page of the same mechanism, so that an edit keeps moment, speed, zoom of
// the clearance, selections and sliders.

function viewState() {
  return {
    head: clock.head,
    perTurn,
    playing: clock.playing,
    speed: Number($("speed").value),
    magnify: clock.sized ? Number($("magnify").value) : null,
    theme: document.documentElement.dataset.theme,
    selected: { ...selected },
    show: { ...scene.show },
    scrolled: window.scrollY,
    moved: Object.fromEntries(
      sliders.setting.moved.map((slide) => [slide.name, slide.values[sliders.setting.positions[given.slides.indexOf(slide)]]]),
    ),
  };
}

function restoreView(view) {
  setTheme(view.theme);
  if (view.perTurn && perTurn)
    clock.head = perTurn * Math.min(Math.floor(view.head / view.perTurn), 1) + (view.head % view.perTurn) * (perTurn / view.perTurn);
  clock.wanted = clock.head;
  clock.begun = performance.now();
  setSpeed(view.speed);
  if (view.magnify !== null) setMagnify(view.magnify);
  for (const [kind, value] of Object.entries(view.selected)) if (OPTIONS[kind]().includes(value)) select(kind, value);
  for (const [kind, value] of Object.entries(view.show)) {
    scene.show[kind] = value;
    $(`show-${kind}`).checked = value;
  }
  play(view.playing);
  let setting = new Setting();
  given.slides.forEach((slide, s) => {
    const at = slide.values.indexOf(view.moved[slide.name]);
    if (at >= 0) setting = setting.with(s, at);
  });
  if (setting.moved.length) sliders.take(setting);
  window.scrollTo(0, view.scrolled);
}

Object.assign(window.live, { viewState, restoreView });
