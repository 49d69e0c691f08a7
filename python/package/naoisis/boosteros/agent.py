"""The classes of ``booster_agent_framework``: an agent with its life cycle, its log and its buttons."""

from __future__ import annotations

import enum
import sys
from collections.abc import Callable, Iterable
from typing import Any

from naoisis.boosteros import _unknown


class AgentFeatures:
    """What an agent has. In naoisis only `enable_auto_getup` does something: the robot gets up by itself."""

    def __init__(self, enable_orchestration: bool = True, enable_auto_getup: bool = False, **features: Any):
        self.enable_auto_getup = enable_auto_getup


class AgentState(enum.Enum):
    """Where an agent is in its life."""

    kUninitialized = 0
    kInactive = 1
    kActive = 2
    kFinalized = 3


class Logger:
    """Writes to standard error, each line with its level."""

    def __getattr__(self, name: str) -> Callable[[object], None]:
        if name not in _LEVELS:
            _unknown.refuse(f"Logger.{name}", _LEVELS)
        return lambda text: print(f"[{name}] {text}", file=sys.stderr)


_LEVELS = ("debug", "info", "warn", "error", "fatal")


class LocaleString:
    """A text in several languages: `LocaleString("text")`, `LocaleString("english", "chinese")` or `LocaleString({"en": ...})`."""

    def __init__(self, text: str | dict[str, str] = "", zh: str | None = None):
        self._texts = dict(text) if isinstance(text, dict) else {"en": text}
        if zh is not None:
            self._texts["zh"] = zh

    def get_string(self, lang: str) -> str:
        """The text in a language, or else in the first one."""
        return self._texts.get(lang, next(iter(self._texts.values()), ""))


Click = Callable[["Component"], LocaleString | None]


class Component:
    """A button. Nobody presses it but the option `--click` of the runner."""

    def __init__(self, id: str, name: LocaleString, click_callback: Click | None = None, **named: Any):
        self.id, self.name, self.click_callback = id, name, click_callback


class IconComponent(Component):
    """A button with an icon."""

    def __init__(self, id: str, name: LocaleString, icon_path: str, click_callback: Click | None = None, **named: Any):
        super().__init__(id, name, click_callback)


class StateIconComponent(IconComponent):
    """A button with an icon and a state."""

    def __init__(
        self,
        id: str,
        name: LocaleString,
        icon_path: str,
        state: int,
        click_callback: Click | None = None,
        **named: Any,
    ):
        super().__init__(id, name, icon_path, click_callback)
        self.state = state


class DefaultStateIconComponent(StateIconComponent):
    """A button that is on or off."""


class ComponentManager:
    """The buttons of an agent."""

    def __init__(self) -> None:
        self._components: dict[str, Component] = {}

    def __getattr__(self, name: str) -> Any:
        _unknown.refuse(f"ComponentManager.{name}", dir(type(self)))

    def add_component(self, component: Component) -> None:
        """Adds a button."""
        self._components[component.id] = component

    def add_components(self, components: Iterable[Component]) -> None:
        """Adds buttons."""
        self._components.update({component.id: component for component in components})

    update_component = add_component

    def get_component(self, component_id: str) -> Component | None:
        """The button with this name."""
        return self._components.get(component_id)

    def get_components(self) -> dict[str, Component]:
        """All buttons by their names."""
        return dict(self._components)


class ComponentStatePageProxy:
    """Pages of buttons. All of them are there at all times."""

    def __init__(self, agent: AgentBase):
        self._manager = agent.component_manager

    def __getattr__(self, name: str) -> Any:
        _unknown.refuse(f"ComponentStatePageProxy.{name}", dir(type(self)))

    def register_page(self, page_id: str, predicate: Callable[..., bool]) -> None:
        """Does nothing."""

    def register_component(self, page_id: str, component: Component | Iterable[Component], *predicate: Any) -> None:
        """Adds buttons."""
        self._manager.add_components([component] if isinstance(component, Component) else component)


class AgentBase:
    """The base of agents. The runner constructs one, activates it, and closes it when the match is over."""

    def __init__(self, agent_features: AgentFeatures | None = None):
        self.agent_features = agent_features or AgentFeatures()
        self.agent_id = type(self).__name__
        self.agent_state = AgentState.kInactive
        self.component_manager = ComponentManager()
        self.logger = Logger()

    def __getattr__(self, name: str) -> Any:
        known = ("agent_id", "agent_state", "component_manager", "logger", *dir(AgentBase))
        _unknown.refuse(f"AgentBase.{name}", known)

    def on_agent_activated(self) -> None:
        """Called when the match begins."""

    def on_agent_close(self) -> None:
        """Called when the match is over."""


def __getattr__(name: str) -> Any:
    return _unknown.placeholder("booster_agent_framework", name, __all__)


__all__ = [
    "AgentBase",
    "AgentFeatures",
    "AgentState",
    "Component",
    "ComponentManager",
    "ComponentStatePageProxy",
    "DefaultStateIconComponent",
    "IconComponent",
    "LocaleString",
    "Logger",
    "StateIconComponent",
]
